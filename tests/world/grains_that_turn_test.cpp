#include <gtest/gtest.h>

#include "brim/body/points/points_body.h"
#include "support/soft_worlds.h"

/// Grains that turn, in small worlds.
namespace brim::grains_that_turn_test {
namespace {

PointsOptions grains(double radius = 0.05) {
  PointsOptions o;
  o.radius = {radius};
  o.density = 1000;
  o.stiffness_damping = 2.0 / 60.0;
  o.slip_speed = 1e-3 * 9.81 / 60.0;
  return o;
}

TEST(GrainsThatTurn, RollDownAPlaneAtFiveSevenths) {
  // Two grains far from each other: a body of one alone has no more velocities than a rigid one.
  constexpr double angle = 0.3;
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    WorldOptions options = testing::options_at(0.05 / 1.5);
    options.environment.gravity = 9.81 * Vec3(std::sin(angle), 0, -std::cos(angle));
    options.response = response;
    World w(options);
    w.add(testing::ground(0.5));
    PointsOptions o = grains();
    o.rolling_friction = 0.0;
    const int b = w.add(testing::named<PointsBody>("grains", std::vector<Vec3>{{0, 0, 0.05}, {0.01, 1, 0.05}}, o));
    testing::run(w, 0.2);
    const double before = w.v(b)[0];
    testing::run(w, 0.5);
    const double a = 5.0 / 7.0 * 9.81 * std::sin(angle);
    EXPECT_NEAR((w.v(b)[0] - before) / 0.5, a, 0.01 * a) << static_cast<int>(response);
    EXPECT_NEAR(w.v(b)[4] * 0.05, w.v(b)[0], 0.01 * w.v(b)[0]) << "it rolls";
  }
}

TEST(GrainsThatTurn, StayWhereRollingResistanceHoldsThem) {
  // tan of the slope 0.06, against a μ_r of 0.1.
  WorldOptions options = testing::options_at(0.05 / 1.5);
  options.environment.gravity = 9.81 * Vec3(0.06, 0, -1).normalized();
  World w(options);
  w.add(testing::ground(0.5));
  const int b = w.add(testing::named<PointsBody>("grains", std::vector<Vec3>{{0, 0, 0.05}, {0.01, 1, 0.05}}, grains()));
  testing::run(w, 1.0);
  EXPECT_LT(w.v(b)[0], 2e-3);
}

TEST(GrainsThatTurn, AClosedCollisionKeepsMomentumAndAngularMomentum) {
  WorldOptions options = testing::options_at(0.05 / 1.5);
  options.environment.gravity.setZero();
  World w(options);
  const std::vector<Vec3> x{{0, 0, 0}, {0.3, 0.05, 0.02}, {0.15, 0.3, 0.03}, {0.16, -0.25, -0.02}};
  const int b = w.add(testing::named<PointsBody>("grains", x, grains()));
  State s = w.state();
  const std::vector<double> v{1, 0, 0, 3, 1, 9, -1, 0, 0, 4, -2, 5, 0, -1, 0, 1, 1, 1, 0, 1, 0, -6, 2, 0};
  s.v = v;
  w.set_state(s);
  w.step();
  const Vec3 p = w.body(b).linear_momentum(w.v(b)), L = w.body(b).angular_momentum(w.v(b));
  const double energy = w.body(b).kinetic_energy(w.v(b));
  for (int i = 0; i < 60; ++i) w.step();
  const double mass = w.body(b).mass();
  EXPECT_LT((w.body(b).linear_momentum(w.v(b)) - p).norm(), 1e-12 * mass);
  EXPECT_LT((w.body(b).angular_momentum(w.v(b)) - L).norm(), 1e-12 * mass);
  EXPECT_LT(w.body(b).kinetic_energy(w.v(b)), 0.9 * energy) << "they have met";
}

TEST(GrainsThatTurn, ContactWithOtherBodiesKeepsBothMomenta) {
  WorldOptions options = testing::options_at(0.05 / 1.5);
  options.environment.gravity.setZero();
  World w(options);
  const int b = w.add(testing::named<PointsBody>("grains", std::vector<Vec3>{{0, 0, 0}, {0.02, 0.11, 0}}, grains()));
  w.set_velocity(b, Vec3(0, 0, 1), Vec3::Zero());
  w.add(testing::box("box", {Vec3(0.05, 0.05, 0.25)}, 0.5, 0.3, 300));
  double linear = 0.0, angular = 0.0;
  bool met = false;
  for (int i = 0; i < 30; ++i) {
    const StepReport r = w.step();
    linear = std::max(linear, r.momentum_error), angular = std::max(angular, r.angular_error);
    met = met || r.contacts > 0;
  }
  EXPECT_TRUE(met);
  EXPECT_LT(linear, 1e-12);
  EXPECT_LT(angular, 1e-12);
}

TEST(GrainsThatTurn, ARunThatIsResumedGoesOnBitForBit) {
  const auto made = [] {
    World w(testing::options_at(0.05 / 1.5));
    w.add(testing::ground(0.5));
    w.add(testing::named<PointsBody>("grains", std::vector<Vec3>{{0, 0, 0.06}, {0.03, 0.01, 0.17}}, grains()));
    return w;
  };
  World one = made(), two = made();
  testing::run(one, 0.4);
  two.set_state(one.state());
  testing::run(one, 0.2), testing::run(two, 0.2);
  EXPECT_EQ(one.hash(), two.hash());
}

}  // namespace
}  // namespace brim::grains_that_turn_test
