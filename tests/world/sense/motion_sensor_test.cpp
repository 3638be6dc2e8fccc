#include "brim/world/sense/motion_sensor.h"

#include <gtest/gtest.h>

#include "brim/body/grid_fluid/grid_fluid_body.h"
#include "brim/core/error.h"
#include "support/sensing.h"
#include "support/soft_worlds.h"

/// Laws of probes of motion.
namespace brim {
namespace {

using namespace testing::sensing;

TEST(MotionSensor, APointOfARigidBodyMovesByItsVelocityAndSpin) {
  WorldOptions o = options_at(0.1);
  World w(o);
  const Vec3 omega(0.3, -0.2, 2.0);
  testing::Start start{Vec3(1, 2, 3), Quat::Identity(), Vec3(0.5, 0, 0), omega};
  w.add(box("box", start));
  SensorModel corner = sensor_on(SensorKind::Motion, "box", "corner");
  corner.point = Vec3(1.5, 2.5, 3.5);
  add_sensor(w, corner);
  add_sensor(w, sensor_on(SensorKind::Motion, "box", "whole"));
  EXPECT_LT((reading_of_axes(w, "corner", "position") - *corner.point).norm(), 1e-12);
  EXPECT_LT((reading_of_axes(w, "corner", "velocity") - start.v - omega.cross(Vec3(0.5, 0.5, 0.5))).norm(), 1e-9);
  for (int i = 0; i < 30; ++i) {
    w.step();
    const Vec3 x = testing::position(w, 0), r = reading_of_axes(w, "corner", "position") - x;
    EXPECT_NEAR(r.norm(), std::sqrt(0.75), 1e-9);
    EXPECT_LT((reading_of_axes(w, "corner", "spin") - testing::spin(w, 0)).norm(), 1e-9);
    EXPECT_LT(
        (reading_of_axes(w, "corner", "velocity") - testing::velocity(w, 0) - testing::spin(w, 0).cross(r)).norm(),
        1e-9);
    EXPECT_LT((reading_of_axes(w, "whole", "acceleration") - Vec3(0, 0, -9.81)).norm(), 1e-9);
  }
}

TEST(MotionSensor, BodiesOfNodesFallAsAWholeAndAtTheirPoints) {
  WorldOptions o = options_at(0.1);
  World w(o);
  w.add(testing::jelly("jelly", 0.5, Vec3(0, 0, 2)));
  w.add(testing::sheet("sheet", 0.8, Vec3(2, 0, 2)));
  w.add(testing::blob("fluid", 4, 0.1, Vec3(4, 0, 2)));
  for (const std::string body : {"jelly", "sheet", "fluid"}) add_sensor(w, sensor_on(SensorKind::Motion, body, body));
  SensorModel point = sensor_on(SensorKind::Motion, "jelly", "corner");
  point.point = Vec3(0.5, 0.5, 2.5);
  add_sensor(w, point);
  const Vec3 start = reading_of_axes(w, "corner", "position");
  EXPECT_LT((start - *point.point).norm(), 1e-9);
  for (int i = 0; i < 6; ++i) w.step();
  const double t = w.state().time;
  for (const std::string name : {"jelly", "sheet", "fluid", "corner"}) {
    EXPECT_NEAR(reading(w, name, "velocity_z"), -9.81 * t, 1e-3) << name;
    EXPECT_NEAR(reading(w, name, "acceleration_z"), -9.81, 0.05) << name;
  }
  EXPECT_NEAR(reading(w, "corner", "position_z") - start.z(), -0.5 * 9.81 * t * t, 1e-3);
}

TEST(MotionSensor, APointOfAParticleFluidIsItsNearestParticle) {
  World w(options_at(0.1));
  w.add(testing::blob("fluid", 3, 0.1, Vec3(0, 0, 1)));
  SensorModel m = sensor_on(SensorKind::Motion, "fluid", "fluid");
  m.point = Vec3(0.14, 0.15, 1.06);
  add_sensor(w, m);
  for (int i = 0; i < 6; ++i) w.step();
  const double t = w.state().time;
  EXPECT_NEAR(reading(w, "fluid", "position_x"), 0.15, 1e-3);
  EXPECT_NEAR(reading(w, "fluid", "position_z"), 1.05 - 0.5 * 9.81 * t * t, 1e-3);
  EXPECT_NEAR(reading(w, "fluid", "velocity_z"), -9.81 * t, 1e-3);
}

TEST(MotionSensor, WhatHasNoPointsOrIsSeveralIsRefused) {
  World w(options_at(0.1));
  w.add(ground(0.5));
  GridFluidModel water;
  water.grid.dx = 0.1, water.grid.n = Vec3i::Constant(4);
  water.distance = [](const Vec3& x) { return x.z() - 0.2; };
  w.add(testing::named<GridFluidBody>("fluid", water));
  for (const char* name : {"box.0", "box.1"}) w.add(box(name, {Vec3(0, 0, 9)}));
  SensorModel m = sensor_on(SensorKind::Motion, "fluid");
  m.point = Vec3(0, 0, 1);
  EXPECT_THROW(add_sensor(w, m), InputError);
  EXPECT_THROW(add_sensor(w, sensor_on(SensorKind::Motion, "box")), InputError);
  EXPECT_THROW(add_sensor(w, sensor_on(SensorKind::Motion, "nobody")), InputError);
}

}  // namespace
}  // namespace brim
