#include "brim/world/given_values.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "brim/body/obstacle/obstacle_body.h"
#include "brim/body/rigid/rigid_body.h"
#include "brim/world/applied_force.h"
#include "brim/world/attachment.h"
#include "brim/world/watcher.h"
#include "support/edited_worlds.h"

/// That a world refuses what it cannot mean, by a message, and is then as before.
namespace brim::testing::given_values_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

RigidModel sphere() {
  RigidModel m;
  m.shape = make_sphere(0.1);
  m.part.voxel_size = 0.02;
  m.inertia = 0.004 * Mat3::Identity();
  return m;
}

std::string of_model(const std::function<void(RigidModel&)>& change) {
  return message([&] {
    RigidModel m = sphere();
    change(m);
    World w;
    auto body = std::make_unique<RigidBody>(std::move(m));
    body->set_name("it");
    w.add(std::move(body));
  });
}

TEST(GivenValues, NumbersThatAreNotThereAreRefusedEverywhere) {
  World w(told());
  w.add(ground(0.5));
  add_rigid(w);
  for (const int b : {99, -1, std::numeric_limits<int>::max()}) {
    const auto refused = [&](const char* what, const std::function<void()>& f) {
      EXPECT_EQ(message(f), fmt::format("{} {} is not there; there are 6", what, b));
    };
    refused("body: body", [&] { w.body(b); });
    refused("part: part", [&] { w.part(b); });
    refused("q: body", [&] { w.q(b); });
    refused("v: body", [&] { w.v(b); });
    refused("body: body", [&] { w.drives(b); });
    refused("removed: body", [&] { w.removed(b); });
    refused("frozen: body", [&] { w.frozen(b); });
    refused("asleep: body", [&] { w.asleep(b); });
    refused("wake: body", [&] { w.wake(b); });
    refused("remove: body", [&] { w.remove(b); });
    refused("freeze: body", [&] { w.freeze(b); });
    refused("set_material: body", [&] { w.set_material(b, {}); });
    refused("voxel_size: part", [&] { w.voxel_size(b); });
    refused("density: part", [&] { w.density(b, 0.1, {}, {}); });
    refused("grab: body", [&] { w.grab(b, Vec3::Zero()); });
    refused("set_drive: body", [&] { w.set_drive(b, "x", 0, 0); });
    refused("aim: body", [&] { w.aim(b, 0); });
    const auto none = [&](const char* what, const std::function<void()>& f) {
      EXPECT_EQ(message(f), fmt::format("{} {} is not there; there are 0", what, b));
    };
    none("set_drive: attachment", [&] { w.set_drive(b, 1.0, 0.0); });
    none("detach: attachment", [&] { w.detach(b); });
    none("detached: attachment", [&] { w.detached(b); });
    none("attachment: attachment", [&] { w.attachment(b); });
    none("attachment_id: attachment", [&] { w.attachment_id(b); });
    none("aim: attachment", [&] { w.aim(b); });
    none("force_id: force", [&] { w.force_id(b); });
  }
  EXPECT_NE(message([&] { w.material(99); }), "");
  EXPECT_NE(message([&] { w.aim(1, 0); }), "");
  EXPECT_NE(message([&] { w.watch(nullptr); }), "");
  EXPECT_NE(message([&] { w.schedule(0.0, nullptr); }), "");
  EXPECT_TRUE(w.step().ok);
}

TEST(GivenValues, ModelsThatNoSolidHasAreRefused) {
  EXPECT_EQ(of_model([](RigidModel&) {}), "");
  EXPECT_EQ(of_model([](RigidModel& m) { m.rotation = Quat(2, 0, 0, 0); }), "");
  EXPECT_EQ(of_model([](RigidModel& m) { m.inertia = Vec3(1, 1, 2).asDiagonal(); }), "");
  const auto says = [](const std::string& part, const std::function<void(RigidModel&)>& change) {
    const std::string found = of_model(change);
    EXPECT_NE(found.find(part), std::string::npos) << found << " for " << part;
  };
  says("no shape", [](RigidModel& m) { m.shape = nullptr; });
  says("mass is", [](RigidModel& m) { m.mass = 0.0; });
  says("position is (nan", [](RigidModel& m) { m.position.x() = kNan; });
  says("velocity is (nan", [](RigidModel& m) { m.velocity.x() = kNan; });
  says("angular velocity is (inf", [](RigidModel& m) { m.angular_velocity.x() = INFINITY; });
  says("quaternion", [](RigidModel& m) { m.rotation = Quat(0, 0, 0, 0); });
  says("quaternion", [](RigidModel& m) { m.rotation = Quat(kNan, 0, 0, 0); });
  says("linear_damping is -5", [](RigidModel& m) { m.linear_damping = -5; });
  says("angular_damping is nan", [](RigidModel& m) { m.angular_damping = kNan; });
  says("not finite", [](RigidModel& m) { m.inertia *= kNan; });
  says("not symmetric", [](RigidModel& m) { m.inertia(0, 1) = 0.001; });
  says("no solid has the principal moments 1, 1 and 10",
       [](RigidModel& m) { m.inertia = Vec3(1, 10, 1).asDiagonal(); });
  says("not positive definite", [](RigidModel& m) { m.inertia = Vec3(1, -1, 1).asDiagonal(); });
  says("friction nan", [](RigidModel& m) { m.part.material.friction = kNan; });
  says("friction -1", [](RigidModel& m) { m.part.material.friction = -1; });
  says("restitution 3", [](RigidModel& m) { m.part.material.restitution = 3; });
  says("voxel_size -1", [](RigidModel& m) { m.part.voxel_size = -1; });
  says("voxel_size nan", [](RigidModel& m) { m.part.voxel_size = kNan; });
  says("thickness nan", [](RigidModel& m) { m.part.thickness = kNan; });
  says("thickness 0", [](RigidModel& m) { m.part.thickness = 0; });
}

TEST(GivenValues, OptionsAndObstaclesAreCheckedToo) {
  const auto with = [](const std::function<void(WorldOptions&)>& change) {
    WorldOptions o;
    change(o);
    return message([&] { World w(o); });
  };
  EXPECT_NE(with([](WorldOptions& o) { o.environment.gravity.y() = kNan; }), "");
  EXPECT_NE(with([](WorldOptions& o) { o.constraint_sweeps = 0; }), "");
  EXPECT_NE(with([](WorldOptions& o) { o.constraint_tolerance = kNan; }), "");
  EXPECT_NE(with([](WorldOptions& o) { o.pair_materials[{"a", "b"}].restitution = 2; }), "");
  EXPECT_EQ(with([](WorldOptions&) {}), "");
  const ObstacleModel without_shape;
  EXPECT_NE(message([&] { ObstacleBody body(without_shape); }), "");
  ObstacleModel placed;
  placed.shape = make_sphere(1.0);
  placed.keys[0].position.x() = kNan;
  EXPECT_NE(message([&] { ObstacleBody body(placed); }), "");
}

TEST(GivenValues, AStepThatFailsNamesTheFirstBodyWhoseNumbersAreNotFinite) {
  World w(told());
  w.add(ground(0.5));
  w.add(ball("calm", {Vec3(0, 0, 1)}, 0.5, 0.3));
  w.add(ball("thrown", {Vec3(3, 0, 1)}, 0.5, 0.3));
  AppliedForce force;
  force.name = "too much", force.bodies = {"thrown"}, force.force = Vec3(1e308, 1e308, 1e308);
  force.scale = {{0.0, 1e6}};
  w.apply(force);
  const StepReport report = w.step();
  EXPECT_FALSE(report.ok);
  ASSERT_FALSE(report.warnings.empty());
  EXPECT_EQ(report.warnings.back().code, "not_finite");
  EXPECT_NE(report.warnings.back().message.find("of 'thrown'"), std::string::npos) << report.warnings.back().message;
}

TEST(GivenValues, AMovedWorldStepsOnAndTellsItsWatchersOfItself) {
  World a(told()), b(told());
  a.add(ground(0.5));
  add_rigid(a);
  for (int s = 0; s < 3; ++s) a.step();
  World twin(told());
  twin.add(ground(0.5));
  add_rigid(twin);
  struct Sees : Watcher {
    const World* seen = nullptr;
    void substep(const World& w, double, double) override { seen = &w; }
    void end_step(const World&, const StepReport&) override {}
  };
  for (int s = 0; s < 3; ++s) twin.step();
  auto watcher = std::make_unique<Sees>();
  const Sees& sees = *watcher;
  a.watch(std::move(watcher));
  b = std::move(a);
  for (int s = 0; s < 3; ++s) b.step(), twin.step();
  EXPECT_EQ(b.hash(), twin.hash());
  EXPECT_EQ(sees.seen, &b);
}

TEST(GivenValues, TheNameOfARemovedBodyStaysReservedAndTheMessageSaysSo) {
  World w(told());
  w.add(ground(0.5));
  w.add(ball("ball", {Vec3(0, 0, 1)}, 0.5, 0.3));
  EXPECT_EQ(message([&] { w.add(ball("ball", {Vec3(2, 0, 1)}, 0.5, 0.3)); }),
            "world: two bodies are named 'ball'; names must be unique");
  w.remove(1);
  EXPECT_EQ(message([&] { w.add(ball("ball", {Vec3(2, 0, 1)}, 0.5, 0.3)); }),
            "world: 'ball' is the name of a removed body, for which it stays reserved; use another");
}

}  // namespace
}  // namespace brim::testing::given_values_test
