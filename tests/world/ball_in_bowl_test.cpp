#include <gtest/gtest.h>

#include <cmath>

#include "support/worlds.h"

/// A ball that slides to and fro in a bowl without friction keeps its swing: its rows turn with the hollow.
namespace brim::ball_in_bowl_test {
namespace {

/// Largest distances from the axis after each half swing, [m], of a ball that starts at 0.45.
std::vector<double> swings(double h, double dt, const Vec3& place) {
  constexpr double kWay = 0.9;  ///< [m] of the ball's centre from the bowl's
  WorldOptions o = testing::options_at(h);
  o.response = Response::Constraint, o.time_step = dt;
  World w(o);
  w.add(testing::obstacle("bowl", make_bowl(1.05, 0.05), 0.0, place));
  const double x = 0.45;
  w.add(testing::ball("ball", {place + Vec3(x, 0, -std::sqrt(kWay * kWay - x * x))}, 0.0, 0.1));
  std::vector<double> out;
  double before = x, now = x;
  for (double t = 0.0; t < 3.0; t += dt) {
    w.step();
    const double next = std::abs(testing::position(w, 1).x() - place.x());
    if (now > before && now >= next) out.push_back(now);
    before = now, now = next;
  }
  return out;
}

TEST(BallInABowl, KeepsItsSwingAtSmallSteps) {
  for (const double h : {0.025, 0.0125})
    for (const Vec3& place : {Vec3(0, 0, 0), Vec3(0.0037, 0.0081, 0.0113)}) {
      const std::vector<double> most = swings(h, 1.0 / 1920.0, place);
      ASSERT_EQ(most.size(), 3u);
      // A fifth of a percent a swing was gained by normals that stayed behind by a tenth of a voxel.
      for (const double x : most) EXPECT_NEAR(x, 0.45, 6e-4) << "voxels of " << h;
    }
}

TEST(BallInABowl, KeepsItsSwingToSecondOrderInTheStep) {
  // With normals of the start and velocities of the end 1.3 percent a swing were lost at a sixtieth of a second.
  for (const double dt : {1.0 / 60.0, 1.0 / 120.0, 1.0 / 240.0}) {
    const std::vector<double> most = swings(0.025, dt, Vec3(0.0037, 0.0081, 0.0113));
    ASSERT_EQ(most.size(), 3u);
    for (std::size_t i = 0; i < most.size(); ++i)
      EXPECT_NEAR(most[i], 0.45, 2e-4 + 4.0 * dt * dt) << "swing " << i << " at " << dt;
  }
}

}  // namespace
}  // namespace brim::ball_in_bowl_test
