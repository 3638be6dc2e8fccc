#include <gtest/gtest.h>

#include "support/worlds.h"

namespace brim::rolling_resistance_test {
namespace {

constexpr double kRadius = 0.2, kReach = 0.02, kGravity = 9.81;

/// A world in which all pairs have a rolling resistance of kReach, on a slope.
WorldOptions options(Response response, double slope = 0.0) {
  WorldOptions o = testing::options_at(kRadius / 4.0);
  o.response = response;
  o.time_step = 1.0 / 120.0;
  o.environment.gravity = kGravity * Vec3(std::sin(slope), 0.0, -std::cos(slope));
  o.pair_materials[{"default", "default"}].rolling_resistance = kReach;
  return o;
}

testing::Start rolling(double speed) {
  return {Vec3(0.01, 0.02, kRadius), Quat::Identity(), Vec3(speed, 0, 0), Vec3(0, speed / kRadius, 0)};
}

class RollingResistance : public ::testing::TestWithParam<Response> {};

TEST_P(RollingResistance, SlowsABallAsItsTorqueSaysAndStopsIt) {
  World w(options(GetParam()));
  w.add(testing::ground(0.5));
  const int b = w.add(testing::ball("ball", rolling(1.0), 0.5, kRadius));
  // b N = (I + m R²) α
  const double a = kGravity * kReach / kRadius / 1.4;
  for (int i = 0; i < 120; ++i) w.step();
  EXPECT_NEAR(testing::velocity(w, b).x(), 1.0 - a, 0.01);
  EXPECT_NEAR(testing::spin(w, b).y() * kRadius, testing::velocity(w, b).x(), 1e-3);
  for (int i = 0; i < 120; ++i) w.step();
  EXPECT_LT(testing::velocity(w, b).norm(), 1e-4);
  EXPECT_LT(testing::spin(w, b).head<2>().norm() * kRadius, 1e-4);
}

TEST_P(RollingResistance, HoldsOnASlopeBelowItsOwnAndNotAbove) {
  for (const double share : {0.5, 2.0}) {
    const double slope = std::atan(share * kReach / kRadius);
    World w(options(GetParam(), slope));
    w.add(testing::ground(0.5));
    const int b = w.add(testing::ball("ball", rolling(0.0), 0.5, kRadius));
    for (int i = 0; i < 120; ++i) w.step();
    const double a = kGravity * (std::sin(slope) - kReach / kRadius * std::cos(slope)) / 1.4;
    EXPECT_NEAR(testing::velocity(w, b).x(), std::max(0.0, a), share < 1.0 ? 1e-3 : 0.01 * a) << share;
  }
}

TEST_P(RollingResistance, KeepsMomentaWhereTwoBallsRollOnEachOther) {
  // They meet off their centres, and push each other for some steps.
  WorldOptions o = options(GetParam());
  o.environment.gravity.setZero();
  double spin_without = 0.0;
  for (const double reach : {0.0, kReach}) {
    o.pair_materials[{"default", "default"}].rolling_resistance = reach;
    World w(o);
    const Vec3 aside(0.0, 0.1, 0.03);
    const int a = w.add(testing::ball("a", {Vec3(-0.3, 0, 0), Quat::Identity(), Vec3(1, 0, 0), Vec3(0, 9, -9)}, 0.5,
                                      kRadius)),
              b = w.add(testing::ball("b", {Vec3(0.3, 0, 0) + aside, Quat::Identity(), Vec3(-1, 0, 0)}, 0.5, kRadius));
    const auto momenta = [&] {
      Vec3 p = Vec3::Zero(), L = Vec3::Zero();
      for (const int i : {a, b}) p += w.body(i).linear_momentum(w.v(i)), L += w.body(i).angular_momentum(w.v(i));
      return std::pair(p, L);
    };
    w.step();
    const auto [p, L] = momenta();
    for (int i = 0; i < 60; ++i) w.step();
    const double mass = w.body(a).mass();
    EXPECT_LT((momenta().first - p).norm(), 1e-12 * mass);
    EXPECT_LT((momenta().second - L).norm(), 1e-9 * mass);
    const double relative = (testing::spin(w, a) - testing::spin(w, b)).norm();
    if (reach == 0.0)
      spin_without = relative;
    else
      EXPECT_LT(relative, 0.98 * spin_without);
  }
}

TEST_P(RollingResistance, NeverAddsEnergy) {
  World w(options(GetParam()));
  w.add(testing::ground(0.3));
  std::vector<int> balls;
  for (int i = 0; i < 3; ++i)
    balls.push_back(w.add(testing::ball(
        "ball" + std::to_string(i),
        {Vec3(0.35 * i, 0.1 * i, kRadius + 0.02), Quat::Identity(), Vec3(1.0 - 0.8 * i, 0, 0)}, 0.3, kRadius)));
  const auto energy = [&] {
    double sum = 0.0;
    for (const int b : balls) sum += w.body(b).kinetic_energy(w.v(b));
    return sum;
  };
  for (int i = 0; i < 60; ++i) w.step();
  double last = energy();
  for (int i = 0; i < 240; ++i) {
    w.step();
    EXPECT_LE(energy(), last + 1e-6);
    last = energy();
  }
  // They may still spin where they stand.
  for (const int b : balls) EXPECT_LT(testing::velocity(w, b).norm(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Responses, RollingResistance, ::testing::Values(Response::Penalty, Response::Constraint),
                         [](const auto& i) { return i.param == Response::Penalty ? "Penalty" : "Rows"; });

}  // namespace
}  // namespace brim::rolling_resistance_test
