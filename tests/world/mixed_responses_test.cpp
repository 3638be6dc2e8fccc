#include <gtest/gtest.h>

#include <cmath>

#include "support/momentum.h"
#include "support/soft_worlds.h"

/// Worlds whose response is left open: rows between solids, penalties between all others, in one step.
namespace brim::mixed_responses_test {
namespace {

using testing::ball;
using testing::box;
using testing::ground;
using testing::jelly;
using testing::position;
using testing::velocity;

WorldOptions open_at(double h, double restitution = 0.0) {
  WorldOptions o = testing::options_at(h);
  o.response = Response::Inherit;
  o.pair_materials[{"default", "default"}].restitution = restitution;
  return o;
}

const PairReport& pair_of(const World& w, const StepReport& report, int a, int b) {
  static const PairReport none;
  for (const PairReport& r : report.pairs) {
    const int x = w.part(r.part_a).body, y = w.part(r.part_b).body;
    if (std::min(x, y) == std::min(a, b) && std::max(x, y) == std::max(a, b)) return r;
  }
  return none;
}

/// A stack of three boxes, and a ball that bounces and rolls. @param beside  a soft block lies apart from them
World bouncing(bool beside) {
  World w(open_at(0.05, 0.8));
  w.add(ground(0.5));
  for (int i = 0; i < 3; ++i) w.add(box("box" + std::to_string(i), {Vec3(0.03 * i, 0, 0.2 + 0.4 * i)}, 0.5, 0.4));
  testing::Start s;
  s.x = Vec3(1, 0, 0.5), s.v = Vec3(1, 0, 0);
  w.add(ball("ball", s, 0.5, 0.2));
  if (beside) w.add(jelly("jelly", 0.4, Vec3(-3, -3, 0)));
  return w;
}

TEST(MixedResponses, ASoftBodyElsewhereChangesNothingForSolids) {
  World alone = bouncing(false), mixed = bouncing(true);
  for (int s = 0; s < 90; ++s) {
    ASSERT_TRUE(alone.step().ok);
    ASSERT_TRUE(mixed.step().ok);
    for (int b = 1; b < 5; ++b)
      ASSERT_LT((position(alone, b) - position(mixed, b)).norm(), 2e-5) << alone.body(b).name() << ", step " << s;
  }
  EXPECT_GT(position(mixed, 4).x(), 2.0) << "it rolls";
}

TEST(MixedResponses, ASolidBouncesInAWorldWithSoftBodies) {
  World w(open_at(0.05, 1.0));
  w.add(ground(0.0));
  w.add(ball("ball", {Vec3(0, 0, 1.2)}, 0.0, 0.2));
  w.add(jelly("jelly", 0.4, Vec3(2, 0, 0)));
  double highest = 0.0;
  bool fell = false;
  for (int s = 0; s < 60; ++s) {
    const StepReport r = w.step();
    for (const Warning& warning : r.warnings) EXPECT_NE(warning.code, "no_restitution");
    fell = fell || velocity(w, 1).z() < -3.0;
    if (fell) highest = std::max(highest, position(w, 1).z());
  }
  EXPECT_NEAR(highest, 1.2, 0.02);
}

TEST(MixedResponses, AJellyCarriesAStackOfSolids) {
  World w(open_at(0.05));
  w.add(ground(0.5));
  w.add(jelly("jelly", 0.6, Vec3(-0.3, -0.3, 0)));
  const int lower = w.add(box("lower", {Vec3(0, 0, 0.8)}, 0.5, 0.4, 100.0)),
            upper = w.add(box("upper", {Vec3(0, 0, 1.2)}, 0.5, 0.4, 100.0));
  StepReport report;
  for (int s = 0; s < 240; ++s) {
    report = w.step();
    ASSERT_TRUE(report.ok);
  }
  const double weight = 9.81 * 100.0 * 0.064;
  EXPECT_NEAR(std::abs(pair_of(w, report, lower, upper).force_on_a.z()), weight, 0.01 * weight);
  EXPECT_NEAR(std::abs(pair_of(w, report, 1, lower).force_on_a.z()), 2.0 * weight, 0.02 * weight);
  EXPECT_LT(velocity(w, upper).norm(), 5e-3);
  EXPECT_NEAR(position(w, upper).z() - position(w, lower).z(), 0.4, 1e-3);
}

/// A box falls onto a box of a hundredth of its mass that lies on a jelly: the jelly gives way as if the heavy one fell
/// on it alone, whatever the moment of the impact within a step.
TEST(MixedResponses, RowsKnowWhatPenaltiesHoldBehindALightBody) {
  for (const double fall : {0.03, 0.04, 0.045, 0.05, 0.055, 0.06, 0.07, 0.08}) {
    SCOPED_TRACE(fall);
    World w(open_at(0.05));
    w.add(ground(0.5));
    w.add(jelly("jelly", 0.6, Vec3(-0.3, -0.3, 0)));
    const int light = w.add(box("light", {Vec3(0, 0, 0.8)}, 0.5, 0.4, 3.0)),
              heavy = w.add(box("heavy", {Vec3(0, 0, 1.2 + fall)}, 0.5, 0.4, 300.0));
    World bare(open_at(0.05));
    bare.add(ground(0.5));
    bare.add(jelly("jelly", 0.6, Vec3(-0.3, -0.3, 0)));
    const int single = bare.add(box("heavy", {Vec3(0, 0, 0.8 + fall)}, 0.5, 0.4, 300.0));
    double least = 1.0, lowest = 1.0, deepest = 1.0;
    for (int s = 0; s < 60; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      for (const Warning& warning : r.warnings) EXPECT_NE(warning.code, "no_convergence") << warning.message;
      ASSERT_TRUE(bare.step().ok);
      least = std::min(least, position(w, heavy).z() - position(w, light).z());
      lowest = std::min(lowest, position(w, light).z());
      deepest = std::min(deepest, position(bare, single).z());
    }
    EXPECT_GT(least, 0.4 - 0.1 * 0.05) << "a tenth of a voxel";
    EXPECT_NEAR(lowest, deepest, 0.1 * (0.8 - deepest));
  }
}

TEST(MixedResponses, TogetherKeepMomentum) {
  WorldOptions o = open_at(0.05);
  o.environment.gravity.setZero();
  World w(o);
  w.add(jelly("jelly", 0.4, Vec3(-0.2, -0.2, -0.2)));
  testing::Start left, right;
  left.x = Vec3(-0.41, 0.05, 0.02), left.v = Vec3(2, 0, 0);
  right.x = Vec3(-0.82, 0.02, 0.1), right.v = Vec3(4, 0, 0);
  w.add(box("first", left, 0.5, 0.4));
  w.add(box("second", right, 0.5, 0.4));
  const auto before = testing::momentum(w);
  bool rows = false, penalties = false;
  for (int s = 0; s < 30; ++s) {
    const StepReport r = w.step();
    ASSERT_TRUE(r.ok);
    rows = rows || pair_of(w, r, 1, 2).force_on_a.norm() > 1.0;
    penalties = penalties || pair_of(w, r, 0, 1).force_on_a.norm() > 1.0;
  }
  EXPECT_TRUE(rows && penalties);
  const auto after = testing::momentum(w);
  EXPECT_LT((after.linear - before.linear).norm(), 1e-9 * before.linear.norm());
}

}  // namespace
}  // namespace brim::mixed_responses_test
