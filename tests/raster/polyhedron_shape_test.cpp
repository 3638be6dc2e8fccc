#include "brim/raster/polyhedron_shape.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/mesh/primitives.h"
#include "brim/raster/averaged_distances.h"

namespace brim::polyhedron_shape_test {
namespace {

TEST(PolyhedronShape, IsThatOfTheEqualBox) {
  const Vec3 size(0.9, 0.5, 0.3);
  const auto box = make_box(size), solid = make_polyhedron(*convex_polyhedron(shapes::box(size)));
  EXPECT_NEAR(solid->thickness(), 0.3, 1e-12);
  EXPECT_LT((solid->bounds().hi - box->bounds().hi).norm(), 1e-12);
  EXPECT_LT((solid->bounds().lo - box->bounds().lo).norm(), 1e-12);
  DensityBlock a, b;
  constexpr double h = 0.1;
  for (int tile = -1; tile < 1; ++tile) {
    box->fill({}, {tile, 0, -1}, h, 3.0 * h, a), solid->fill({}, {tile, 0, -1}, h, 3.0 * h, b);
    for (int n = 0; n < kBlockSize * kBlockSize * kBlockSize; ++n) EXPECT_NEAR(a.rho[n], b.rho[n], 1e-12);
  }
}

TEST(PolyhedronShape, IsAveragedAsTheEqualBox) {
  const Vec3 size(0.9, 0.5, 0.3);
  constexpr double w = 0.3;
  const auto box = make_box(size), solid = make_polyhedron(*convex_polyhedron(shapes::box(size)));
  const KnownDistance &a = dynamic_cast<const AveragedDistances&>(*box).averaged(w),
                      &b = dynamic_cast<const AveragedDistances&>(*solid).averaged(w);
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> u(-0.6, 0.6);
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double x = u(rng), y = u(rng);
    const Vec3 p(x, y, u(rng));
    const double exact = a.rough_distance(p);
    if (std::abs(exact) < 0.4 * w) worst = std::max(worst, std::abs(b.rough_distance(p) - exact));
  }
  EXPECT_LT(worst, 0.05 * w);
}

}  // namespace
}  // namespace brim::polyhedron_shape_test
