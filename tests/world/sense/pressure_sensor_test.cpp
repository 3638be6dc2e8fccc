#include "brim/world/sense/pressure_sensor.h"

#include <gtest/gtest.h>

#include <numeric>

#include "brim/core/error.h"
#include "support/sensing.h"
#include "support/worlds.h"

/// Laws of pressure maps.
namespace brim {
namespace {

using namespace testing::sensing;

SensorModel map_of(const std::string& body, const Vec3& corner, double side, int cells) {
  SensorModel m = sensor_on(SensorKind::Pressure, body, "map");
  m.grid = SensorModel::Grid{corner, Vec3(side, 0, 0), Vec3(0, side, 0), cells, cells};
  return m;
}

double integral(const World& w, double cell_area) {
  const auto map = find_sensors(w)->map(static_cast<std::size_t>(find_sensors(w)->find("map")));
  return cell_area * std::accumulate(map.begin(), map.end(), 0.0);
}

TEST(PressureSensor, TheIntegralIsTheForceOfThePlate) {
  World w(options_at(0.05));
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0.01, 0.02, 0.5)}));
  add_sensor(w, map_of("ground", Vec3(-1, -1, 0), 2.0, 20));
  add_sensor(w, sensor_on(SensorKind::Force, "ground", "plate"));
  for (int i = 0; i < 60; ++i) {
    w.step();
    const double force = -reading(w, "plate", "force_z");
    EXPECT_NEAR(integral(w, 0.01), force, 1e-9 * (1.0 + force));
    EXPECT_NEAR(reading(w, "map", "force"), force, 1e-9 * (1.0 + force));
  }
  EXPECT_NEAR(reading(w, "map", "force"), 9810, 98.1);
  EXPECT_NEAR(reading(w, "map", "outside"), 0.0, 1e-9);
  // Under the middle of a flat face weight is spread evenly: m g / A.
  const auto map = find_sensors(w)->map(0);
  EXPECT_NEAR(map[10 * 20 + 10], 9810, 0.1 * 9810);
  EXPECT_EQ(map[0], 0.0);
  EXPECT_NEAR(reading(w, "map", "center_x"), 1.01, 0.02);
}

TEST(PressureSensor, WhatPressesBesideTheGridIsOutside) {
  World w(options_at(0.05));
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0, 0, 0.5)}));
  add_sensor(w, map_of("ground", Vec3(0, -1, 0), 2.0, 20));  // under its right half
  run(w, 1.0);
  EXPECT_NEAR(reading(w, "map", "force") + reading(w, "map", "outside"), 9810, 98.1);
  EXPECT_NEAR(reading(w, "map", "force"), 4905, 0.05 * 4905);
}

TEST(PressureSensor, AGridIsCarriedByItsBody) {
  World w(options_at(0.1));
  w.add(ground(0.0));
  w.add(box("sledge", {Vec3(0, 0, 0.5), Quat::Identity(), Vec3(2, 0, 0)}));
  SensorModel m = map_of("sledge", Vec3(-1, 1, 0), 2.0, 10);
  m.grid->y = Vec3(0, -2, 0);  // x × ŷ points out of the body, down
  add_sensor(w, m);
  run(w, 1.0);
  EXPECT_GT(testing::position(w, 1).x(), 1.9);
  EXPECT_NEAR(reading(w, "map", "force"), 9810, 98.1);
  EXPECT_NEAR(reading(w, "map", "center_x"), 1.0, 0.03);
}

TEST(PressureSensor, GridsThatAreNoneAreRefused) {
  World w(options_at(0.1));
  w.add(ground(0.0));
  SensorModel m = map_of("ground", Vec3::Zero(), 1.0, 4);
  m.grid->y = Vec3(1, 1, 0);
  EXPECT_THROW(add_sensor(w, m), InputError);
  m.grid->y = Vec3(0, 1, 0), m.grid->columns = 0;
  EXPECT_THROW(add_sensor(w, m), InputError);
}

}  // namespace
}  // namespace brim
