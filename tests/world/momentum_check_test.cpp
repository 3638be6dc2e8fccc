#include "brim/world/momentum_check.h"

#include <gtest/gtest.h>

#include <random>

#include "support/worlds.h"

namespace brim::momentum_check_test {
namespace {

constexpr unsigned kSeed = 103;

TEST(MomentumCheck, ContactOfRigidBodiesConservesMomentumToRounding) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  World w(testing::options_at(0.125));
  w.add(testing::ground(0.5));
  for (int i = 0; i < 6; ++i) {
    const double x = u(rng), y = u(rng), a = u(rng), b = u(rng), c = u(rng);
    const testing::Start s{Vec3(0.4 * x + 30, 0.4 * y - 20, 0.8 + 1.1 * i), rotation_from_vector(Vec3(a, b, c)),
                           Vec3(x, y, -1)};
    if (i % 2)
      w.add(testing::ball("ball" + std::to_string(i), s));
    else
      w.add(testing::box("box" + std::to_string(i), s));
  }
  double linear = 0.0, angular = 0.0;
  for (int s = 0; s < 90; ++s) {
    const StepReport r = w.step();
    linear = std::max(linear, r.momentum_error), angular = std::max(angular, r.angular_error);
  }
  EXPECT_LT(linear, 1e-12);
  EXPECT_LT(angular, 1e-10);
  EXPECT_GT(linear + angular, 0.0) << "something was measured";
  RecordProperty("linear", std::to_string(linear));
  RecordProperty("angular", std::to_string(angular));
}

TEST(MomentumCheck, RigidMotionMovesEveryPointOfABodyAsOneSolid) {
  const auto body = testing::box("box", {Vec3(3, -2, 1), rotation_from_vector(Vec3(0.3, 0.2, -0.9))});
  std::vector<double> q(7), v(6);
  body->initial_state(q, v);
  body->update(0.0, q, v);
  const Vec3 t(0.3, -1, 2), w(0.5, 0.7, -0.2);
  ASSERT_TRUE(body->rigid_motion(t, w, v));
  const std::vector<Vec3> points = {Vec3(3, -2, 1.5), Vec3(2.5, -2.2, 0.8), Vec3(0, 0, 0)};
  std::unique_ptr<Map> map;
  body->make_map(0, points, std::vector<std::int32_t>(3, 0), map);
  std::vector<Vec3> u(3);
  map->apply(v, u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_LT((u[i] - t - w.cross(points[i])).norm(), 1e-14);
}

}  // namespace
}  // namespace brim::momentum_check_test
