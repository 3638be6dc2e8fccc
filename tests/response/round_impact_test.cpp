#include "brim/response/round_impact.h"

#include <gtest/gtest.h>

namespace brim::round_impact_test {
namespace {

constexpr double kRadii = 0.2, kDt = 0.02;

TEST(RoundImpact, TheCentresAreBothRadiiApartWhenBallsTouch) {
  for (const double aside : {0.0, 0.05, 0.12, 0.19}) {
    SCOPED_TRACE(aside);
    const Vec3 apart(-0.21, aside, 0.03), velocity(2.0, 0.1, -0.2);
    const auto r = find_round_impact(apart, velocity, kRadii, kDt);
    ASSERT_TRUE(r);
    if (r->time == kDt) continue;
    const Vec3 then = apart + r->time * velocity;
    EXPECT_NEAR(then.norm(), kRadii, 1e-14);
    EXPECT_LT((then / kRadii - r->normal).norm(), 1e-13);
    // The gap along that normal closes at that time.
    EXPECT_NEAR(r->gap + r->time * r->normal.dot(velocity), 0.0, 1e-15);
    EXPECT_LT(r->time, kDt);
  }
}

TEST(RoundImpact, AtTheEndOfTheStepTheGapIsTheTrueOneWhereBallsTouchLater) {
  const Vec3 apart(-0.3, 0.1, 0.0), velocity(2.0, 0.0, 0.0);
  const auto r = find_round_impact(apart, velocity, kRadii, kDt);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->time, kDt);
  EXPECT_NEAR(r->gap + kDt * r->normal.dot(velocity), (apart + kDt * velocity).norm() - kRadii, 1e-15);
}

TEST(RoundImpact, BallsThatPassEachOtherKeepTheirDistance) {
  const Vec3 apart(-0.02, 0.21, 0.0), velocity(2.0, 0.0, 0.0);
  const auto r = find_round_impact(apart, velocity, kRadii, kDt);
  ASSERT_TRUE(r);
  EXPECT_NEAR(r->time, 0.01, 1e-15);
  EXPECT_NEAR(r->gap, 0.01, 1e-15);
  EXPECT_NEAR(r->normal.dot(velocity), 0.0, 1e-15) << "nothing closes";
}

TEST(RoundImpact, NoneWherePartingOrTouching) {
  EXPECT_FALSE(find_round_impact(Vec3(0.3, 0, 0), Vec3(1, 0, 0), kRadii, kDt));
  EXPECT_FALSE(find_round_impact(Vec3(0.3, 0, 0), Vec3::Zero(), kRadii, kDt));
  EXPECT_FALSE(find_round_impact(Vec3(0.19, 0, 0), Vec3(-1, 0, 0), kRadii, kDt));
}

/// Curvature of a ball, or of a side with an axis, as a row holds it.
std::array<float, 3> bend_of(double radius, const Vec3& n, const Vec3& axis = Vec3::Zero()) {
  const Eigen::Vector2d flat = tangents_of(n).transpose() * axis;
  const Eigen::Matrix2d m = (Eigen::Matrix2d::Identity() - flat * flat.transpose()) / radius;
  return {float(m(0, 0)), float(m(0, 1)), float(m(1, 1))};
}

TEST(RoundImpact, CurvaturesTellBallsAndSides) {
  constexpr double kStep = 0.05;
  const Vec3 n = Vec3(0.3, -0.5, 0.7).normalized(), axis = n.cross(Vec3(1, 2, 3)).normalized(), other = n.cross(axis);
  RowPoint row;
  row.normal = n, row.bend_a = bend_of(0.2, n), row.bend_b = bend_of(0.1, n);
  RoundContact r = round_contact(row, kStep);
  EXPECT_NEAR(r.radius_a, 0.2, 1e-7);
  EXPECT_NEAR(r.radius_b, 0.1, 1e-7);
  EXPECT_EQ(r.flat, Vec3::Zero());
  for (const bool swapped : {false, true}) {
    (swapped ? row.bend_a : row.bend_b) = bend_of(0.1, n, axis), (swapped ? row.bend_b : row.bend_a) = bend_of(0.2, n);
    r = round_contact(row, kStep);
    EXPECT_NEAR(r.radius_a + r.radius_b, 0.3, 1e-7);
    EXPECT_NEAR(std::abs(r.flat.dot(axis)), 1.0, 1e-7);
    EXPECT_EQ(r.side_b, !swapped);
  }
  row.bend_a = bend_of(0.2, n, axis), row.bend_b = bend_of(0.1, n, axis);
  EXPECT_TRUE(round_contact(row, kStep).any()) << "sides that lie along each other";
  row.bend_b = bend_of(0.1, n, other);
  EXPECT_FALSE(round_contact(row, kStep).any()) << "crossed sides: the normal stays";
  row.bend_b = {};
  EXPECT_FALSE(round_contact(row, kStep).any()) << "a plane";
  row.bend_b = bend_of(kStep, n);
  EXPECT_FALSE(round_contact(row, kStep).any()) << "an edge has at most this curvature";
}

}  // namespace
}  // namespace brim::round_impact_test
