#include "brim/world/sense/force_sensor.h"

#include <gtest/gtest.h>

#include "support/sensing.h"
#include "support/soft_worlds.h"

/// Laws of force plates.
namespace brim {
namespace {

using namespace testing::sensing;

TEST(ForceSensor, APlateUnderARestingPileReadsItsWeight) {
  World w(options_at(0.1));
  w.add(ground(0.5));
  for (int i = 0; i < 3; ++i)
    w.add(box("box." + std::to_string(i), {Vec3(0.02 * i, 0, 0.25 + 0.5 * i)}, 0.5, 0.5, 400));
  add_sensor(w, sensor_on(SensorKind::Force, "ground", "plate"));
  add_sensor(w, sensor_on(SensorKind::Force, "box", "pile"));
  run(w, 2.0);
  const double weight = 3 * 400 * 0.125 * 9.81;
  EXPECT_NEAR(reading(w, "plate", "force_z"), -weight, 0.01 * weight);
  EXPECT_NEAR(reading(w, "plate", "normal"), weight, 0.01 * weight);
  // What the boxes press on each other is no force on the pile.
  EXPECT_LT((reading_of_axes(w, "pile", "force") + reading_of_axes(w, "plate", "force")).norm(), 1e-6 * weight);
  EXPECT_NEAR(reading(w, "plate", "impulse_z"), reading(w, "plate", "force_z") * w.options().time_step, 1e-9);
}

TEST(ForceSensor, TorqueIsThatOfTheForceAtItsCentre) {
  World w(options_at(0.1));
  w.add(ground(0.0));
  w.add(box("box", {Vec3(1.3, -0.7, 0.25)}, 0.0, 0.5, 400));
  SensorModel plate = sensor_on(SensorKind::Force, "ground", "plate");
  plate.about = Vec3(0.3, 0.3, 0.0);
  add_sensor(w, plate);
  run(w, 2.0);
  const Vec3 force = reading_of_axes(w, "plate", "force"), torque = reading_of_axes(w, "plate", "torque");
  // Of one parallel force: r x F, r from `about` to the middle of the box.
  EXPECT_LT((torque - Vec3(1.0, -1.0, 0.0).cross(force)).norm(), 0.02 * force.norm());
  EXPECT_LT((reading_of_axes(w, "plate", "center") - Vec3(1.3, -0.7, 0.0)).norm(), 0.05);
}

TEST(ForceSensor, TheAreaOfAFlatContactIsKnownToHalfAVoxelAlongItsBorder) {
  World w(options_at(0.05));
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0.01, 0.02, 0.5)}));
  add_sensor(w, sensor_on(SensorKind::Force, "ground", "plate"));
  run(w, 1.0);
  EXPECT_GT(reading(w, "plate", "area"), 0.95 * 0.95);
  EXPECT_LT(reading(w, "plate", "area"), 1.05 * 1.05);
}

TEST(ForceSensor, ARegionReadsWhatLiesOnItAndGoesWhereItsBodyGoes) {
  World w(options_at(0.1));
  w.add(ground(0.0));
  w.add(box("table", {Vec3(0, 0, 0.5), Quat::Identity(), Vec3(1, 0, 0)}, 0.5, 1.0, 1000));
  w.add(box("left", {Vec3(-0.25, 0, 1.15), Quat::Identity(), Vec3(1, 0, 0)}, 0.5, 0.3, 300));
  w.add(box("right", {Vec3(0.25, 0, 1.15), Quat::Identity(), Vec3(1, 0, 0)}, 0.5, 0.3, 700));
  SensorModel half = sensor_on(SensorKind::Force, "table", "half");
  half.with = {"left", "right"};
  half.region = [](const Vec3& x) { return x.x() > 0.0; };
  add_sensor(w, half);
  half.name = "space", half.follows = false;
  half.region = [](const Vec3& x) { return x.x() < 1.0; };
  add_sensor(w, half);
  run(w, 2.0);
  EXPECT_GT(testing::position(w, 1).x(), 1.9);
  const double weight = 700 * 0.027 * 9.81;
  EXPECT_NEAR(reading(w, "half", "force_z"), -weight, 0.01 * weight);
  EXPECT_EQ(reading(w, "space", "force_z"), 0.0);
}

TEST(ForceSensor, SoftAndThinBodiesPressWithTheirWeight) {
  World w = testing::soft_world();
  add_sensor(w, sensor_on(SensorKind::Force, "ground", "plate"));
  add_sensor(w, sensor_on(SensorKind::Force, "jelly", "jelly"));
  double mean = 0.0;
  run(w, 2.0);
  for (int i = 0; i < 60; ++i) {
    w.step();
    mean += reading(w, "plate", "force_z") / 60.0;
  }
  double weight = 0.0;
  for (int b = 1; b < w.body_count(); ++b) weight += 9.81 * w.body(b).mass();
  EXPECT_NEAR(mean, -weight, 0.01 * weight);
}

}  // namespace
}  // namespace brim
