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

}  // namespace
}  // namespace brim::round_impact_test
