#include "brim/response/friction_radius.h"

#include <gtest/gtest.h>

namespace brim::friction_radius_test {
namespace {

std::vector<RowPoint> corners_at(std::initializer_list<Vec3> points) {
  std::vector<RowPoint> rows;
  for (const Vec3& p : points) rows.emplace_back().point = p;
  return rows;
}

/// Distance from a centre to where the friction of each corner acts, over that to the corner.
double share(const std::vector<RowPoint>& rows, const Vec3& center) {
  const RowPoint& r = rows.front();
  return (r.point + r.grip - center).norm() / (r.point - center).norm();
}

TEST(FrictionRadius, OfASquareADiscASegmentAndARectangle) {
  const Vec3 c(3, -2, 1), n = Vec3::UnitZ();
  std::vector<RowPoint> square =
      corners_at({c + Vec3(1, 1, 0), c + Vec3(-1, -1, 0), c + Vec3(1, -1, 0), c + Vec3(-1, 1, 0)});
  place_grips(square, n, {});
  EXPECT_NEAR(share(square, c), (std::sqrt(2.0) + std::asinh(1.0)) / 3.0 / std::sqrt(2.0), 1e-12);
  std::vector<RowPoint> disc =
      corners_at({c + Vec3(1, 0, 0), c + Vec3(0, 1, 0), c + Vec3(-1, 0, 0), c + Vec3(0, -1, 0)});
  place_grips(disc, n, [](const Vec3&, const Vec3&) { return 1.0; });
  EXPECT_NEAR(share(disc, c), 2.0 / 3.0, 1e-12);
  std::vector<RowPoint> segment = corners_at({c - Vec3(2, 0, 0), c + Vec3(2, 0, 0)});
  place_grips(segment, n, {});
  EXPECT_NEAR(share(segment, c), 0.5, 1e-12);
  // Twice as long as wide, by sums over 400 x 400 cells.
  std::vector<RowPoint> slab =
      corners_at({c + Vec3(2, 1, 0), c + Vec3(-2, 1, 0), c + Vec3(-2, -1, 0), c + Vec3(2, -1, 0)});
  place_grips(slab, n, {});
  double mean = 0.0;
  for (int i = 0; i < 400; ++i)
    for (int j = 0; j < 400; ++j) mean += std::hypot(2.0 * (i + 0.5) / 400, (j + 0.5) / 400) / 160000;
  EXPECT_NEAR(share(slab, c), mean / std::sqrt(5.0), 1e-5);
}

TEST(FrictionRadius, OneCornerKeepsItsPlaceAndGripsLieAcross) {
  std::vector<RowPoint> one = corners_at({Vec3(1, 2, 3)});
  place_grips(one, Vec3::UnitZ(), {});
  EXPECT_EQ(one[0].grip, Vec3::Zero());
  const Vec3 n = Vec3(1, 2, 3).normalized();
  std::vector<RowPoint> rows = corners_at({Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 1, 1)});
  place_grips(rows, n, {});
  for (const RowPoint& r : rows) EXPECT_NEAR(r.grip.dot(n), 0.0, 1e-15);
}

}  // namespace
}  // namespace brim::friction_radius_test
