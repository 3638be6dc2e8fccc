#include "brim/world/impulse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "brim/core/parallel.h"
#include "brim/world/applied_force.h"
#include "brim/world/body_motion.h"
#include "support/edited_worlds.h"

/// Impulses on bodies, and the end of external actions.
namespace brim::testing::impulse_test {
namespace {

double largest(std::span<const double> x) {
  double most = 0.0;
  for (const double a : x) most = std::max(most, std::abs(a));
  return most;
}

TEST(Impulse, OnABoxOffCentreGivesTheAnalyticVelocities) {
  World w(told());
  const Vec3 center(0.3, -0.2, 2.0), J(3, -1, 2), at(0.5, 0.05, 1.9);
  const double density = 300, side = 0.5, mass = density * side * side * side, inertia = mass * side * side / 6.0;
  w.add(box("box", {center}, side, 0.5, density));
  w.set_velocity(0, Vec3(0.1, 0, 0), Vec3(0, 0.2, 0));
  EXPECT_EQ(w.apply_impulse(0, J, at), at);
  const Vec3 dw = (at - center).cross(J) / inertia;
  const std::vector<double> expected = {0.1 + J[0] / mass, J[1] / mass, J[2] / mass, dw[0], 0.2 + dw[1], dw[2]};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(w.v(0)[i], expected[i], 1e-9 * largest(expected)) << i;
  // A point outside acts on the rigid frame too.
  const std::vector<double> before = copy(w.v(0));
  w.apply_impulse(0, J, center + Vec3(5, 0, 0));
  EXPECT_NEAR(w.v(0)[4] - before[4], Vec3(5, 0, 0).cross(J)[1] / inertia, 1e-9 * largest(w.v(0)));
}

/// The matrix of a soft body column by column, and by products: the two ways of velocity_change.
TEST(Impulse, VelocityChangeSolvesTheMassMatrix) {
  for (const double side : {0.5, 0.6}) {
    FemOptions o;
    o.density = 500, o.young = 1e5;
    const int cells = side == 0.5 ? 2 : 4;  // 81 and 375 coordinates: dense and iterated
    const FemBody body(block_at(cells, side, Vec3::Zero()), o);
    std::vector<double> p(body.v_size()), back(p.size(), 0.0);
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = std::sin(1.0 + 3.0 * static_cast<double>(i));
    const std::vector<double> change = velocity_change(body, p);
    body.apply_mass(change, back);
    for (std::size_t i = 0; i < p.size(); ++i) EXPECT_NEAR(back[i], p[i], 1e-12) << i;
  }
}

TEST(Impulse, LeavesFixedNodesAlone) {
  FemOptions o;
  o.density = 500, o.young = 1e5;
  const TetMesh mesh = block_at(3, 0.5, Vec3::Zero());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (mesh.vertices[i].z() < 1e-9) o.fixed.push_back(static_cast<std::int32_t>(i));
  World w(told());
  w.add(named<FemBody>("jelly", mesh, o));
  w.apply_impulse(0, Vec3(1, 2, 3), Vec3(0.25, 0.25, 0.5));
  EXPECT_GT(largest(w.v(0)), 1e-3);
  for (const std::int32_t i : o.fixed)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(w.v(0)[3 * static_cast<std::size_t>(i) + k], 0.0);
  const std::vector<double> before = copy(w.v(0));
  w.apply_impulse(0, Vec3(1, 2, 3), mesh.vertices[static_cast<std::size_t>(o.fixed[0])]);
  EXPECT_EQ(copy(w.v(0)), before) << "of a fixed node";
}

TEST(Impulse, WakesTheBodyAndActsInTheNextStep) {
  WorldOptions o = told(Response::Constraint);
  o.sleep = true;
  World w(o);
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0, 0, 0.25)}, 0.5, 0.5));
  for (int s = 0; s < 300 && !w.asleep(1); ++s) w.step();
  ASSERT_TRUE(w.asleep(1));
  const double height = w.q(1)[2];
  w.apply_impulse(1, Vec3(0, 0, 3.0 * w.body(1).mass()), Vec3(0, 0, 0.5));
  EXPECT_FALSE(w.asleep(1));
  w.step();
  EXPECT_GT(w.q(1)[2], height + 1e-3);
}

TEST(Impulse, AStateFromBeforeTakesItAway) {
  World w(told()), twin(told());
  for (World* each : {&w, &twin}) each->add(ground(0.5)), add_soft(*each), each->step();
  const State before = w.state();
  for (int b = 1; b < 6; ++b) w.apply_impulse(b, Vec3(0.1, 0, 0.2), *center_of_mass(w.body(b)));
  const State after = w.state();
  EXPECT_NE(w.hash(), twin.hash());
  w.step();
  const std::uint64_t stepped = w.hash();
  w.set_state(before);
  w.step(), twin.step();
  EXPECT_EQ(w.hash(), twin.hash());
  w.set_state(after);
  w.step();
  EXPECT_EQ(w.hash(), stepped) << "it is part of the velocities";
}

TEST(Impulse, TheSameBitsForAnyNumberOfThreads) {
  const auto run = [](int threads) {
    const ThreadLimit limit(threads);
    World w(told());
    w.add(ground(0.5));
    add_soft(w);
    for (int b = 1; b <= 6; ++b) w.apply_impulse(b, Vec3(0.1, 0.05, 0.2), *center_of_mass(w.body(b)));
    w.step();
    return w.hash();
  };
  EXPECT_EQ(run(1), run(3));
}

TEST(Impulse, IsRefusedForWhatDoesNotMoveAndForNoNumbers) {
  World w(told());
  w.add(ground(0.5));
  for (const char* name : {"box", "frozen", "gone"}) w.add(box(name, {Vec3(0, 0, 3)}, 0.5, 0.5));
  w.freeze(2), w.remove(3);
  const std::uint64_t before = w.hash();
  const double nan = std::numeric_limits<double>::quiet_NaN(), huge = std::numeric_limits<double>::max();
  const auto told_of = [&](int b, const Vec3& J, const Vec3& at) {
    return message([&] { w.apply_impulse(b, J, at); });
  };
  EXPECT_EQ(told_of(0, Vec3::UnitX(), Vec3::Zero()), "apply_impulse: 'ground' (obstacle) does not move by forces");
  EXPECT_EQ(told_of(2, Vec3::UnitX(), Vec3::Zero()), "apply_impulse: 'frozen' is frozen; let it go first");
  EXPECT_EQ(told_of(3, Vec3::UnitX(), Vec3::Zero()), "apply_impulse: 'gone' was removed");
  const std::string finite = "apply_impulse: 'box' needs an impulse and a point of finite numbers";
  EXPECT_EQ(told_of(1, Vec3(nan, 0, 0), Vec3::Zero()), finite);
  EXPECT_EQ(told_of(1, Vec3::UnitX(), Vec3(0, nan, 0)), finite);
  EXPECT_EQ(told_of(1, Vec3::Constant(huge), Vec3(9, 0, 0)),
            "apply_impulse: 'box' would not have finite velocities; the impulse is too large");
  EXPECT_NE(told_of(4, Vec3::UnitX(), Vec3::Zero()), "");
  EXPECT_NE(told_of(-1, Vec3::UnitX(), Vec3::Zero()), "");
  EXPECT_EQ(w.hash(), before);
}

AppliedForce push(const std::string& name, const Vec3& force) {
  AppliedForce f;
  f.name = name, f.force = force, f.bodies = {"box"};
  return f;
}

TEST(RemoveForce, EndsItAndAStateFromBeforeBringsItBack) {
  WorldOptions o = told();
  o.environment.gravity = Vec3::Zero();
  World w(o);
  w.add(box("box", {Vec3(0, 0, 3)}, 0.5, 0.5));
  for (int i = 0; i < 3; ++i) w.apply(push("push" + std::to_string(i), Vec3(1.0 + i, 0, 0)));
  const std::int64_t last = w.force_id(2);
  const State before = w.state();
  const double dt = o.time_step, m = w.body(0).mass();
  w.remove_force(1);
  EXPECT_EQ(w.force_count(), 2);
  EXPECT_EQ(w.force_id(1), last) << "the place of the one that ended";
  w.step();
  EXPECT_NEAR(w.v(0)[0], 4.0 * dt / m, 1e-12);
  w.set_state(before);
  EXPECT_EQ(w.force_count(), 3);
  w.step();
  EXPECT_NEAR(w.v(0)[0], 6.0 * dt / m, 1e-12);
  w.remove_force(0);
  EXPECT_EQ(w.apply(push("push0", Vec3::UnitX())), 2) << "its name is free again";
  EXPECT_GT(w.force_id(2), last) << "its number is not";
  EXPECT_EQ(message([&] { w.remove_force(3); }), message([&] { w.remove_force(3); }));
  EXPECT_NE(message([&] { w.remove_force(3); }).find("remove_force: force 3"), std::string::npos);
  EXPECT_NE(message([&] { w.remove_force(-1); }), "");
  EXPECT_EQ(w.force_count(), 3);
}

TEST(RemoveForce, EndsAFactorOnGravityAndWakes) {
  WorldOptions o = told(Response::Constraint);
  o.sleep = true;
  World w(o);
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0, 0, 0.25)}, 0.5, 0.5));
  w.add(box("other", {Vec3(3, 0, 3)}, 0.5, 0.5));
  AppliedForce light;
  light.name = "light", light.gravity_scale = 0.0, light.bodies = {"other"};
  w.apply(light);
  for (int s = 0; s < 300 && !(w.asleep(1) && w.asleep(2)); ++s) w.step();
  ASSERT_TRUE(w.asleep(2));
  EXPECT_NEAR(w.q(2)[2], 3.0, 1e-9);
  w.remove_force(0);
  EXPECT_FALSE(w.asleep(1) || w.asleep(2));
  w.step();
  EXPECT_LT(w.v(2)[2], -0.5 * 9.81 * o.time_step);
}

}  // namespace
}  // namespace brim::testing::impulse_test
