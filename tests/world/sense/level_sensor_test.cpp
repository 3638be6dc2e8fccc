#include "brim/world/sense/level_sensor.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "support/sensing.h"
#include "support/soft_worlds.h"

/// Laws of gauges on upright lines.
namespace brim {
namespace {

using namespace testing::sensing;

SensorModel gauge(const std::string& body, double x, double y, const std::string& name = "gauge") {
  SensorModel m = sensor_on(SensorKind::Level, body, name);
  m.point = Vec3(x, y, 0);
  return m;
}

TEST(LevelSensor, ReadsTheTopAndTheLengthOfMatterOnItsLine) {
  World w(options_at(0.05));
  w.add(testing::box("box", {Vec3(0.013, 0.021, 0.5)}));
  w.add(testing::jelly("jelly", 0.5, Vec3(0.813, 0.021, 0.37)));
  add_sensor(w, gauge("box", 0.1, -0.2, "on box"));
  add_sensor(w, gauge("box", 3, 3, "beside"));
  add_sensor(w, gauge("jelly", 1.1, 0.2, "on jelly"));
  EXPECT_NEAR(reading(w, "on box", "level"), 1.0, 1e-3);
  EXPECT_NEAR(reading(w, "on box", "depth"), 1.0, 2e-3);
  EXPECT_NEAR(reading(w, "on jelly", "level"), 0.87, 0.01);
  EXPECT_NEAR(reading(w, "on jelly", "depth"), 0.5, 0.02);
  EXPECT_TRUE(std::isnan(reading(w, "beside", "level")));
  EXPECT_EQ(reading(w, "beside", "depth"), 0.0);
}

TEST(LevelSensor, TheLongestRunIsTheLevelAndAllCountForTheDepth) {
  World w(options_at(0.05));
  w.add(testing::box("box.0", {Vec3(0, 0, 0.5)}));
  w.add(testing::box("box.1", {Vec3(0, 0, 3.0)}, 0.5, 0.3));  // a drop above
  add_sensor(w, gauge("box", 0.05, 0.05));
  EXPECT_NEAR(reading(w, "gauge", "level"), 1.0, 1e-3);
  EXPECT_NEAR(reading(w, "gauge", "depth"), 1.3, 4e-3);
}

TEST(LevelSensor, ABlobOfParticlesHasTheHeightOfItsLattice) {
  World w(options_at(0.1));
  w.add(testing::blob("fluid", 8, 0.1, Vec3(0, 0, 1)));
  add_sensor(w, gauge("fluid", 0.4, 0.4));
  EXPECT_NEAR(reading(w, "gauge", "level"), 1.8, 0.05);
  EXPECT_NEAR(reading(w, "gauge", "depth"), 0.8, 0.1);
}

TEST(LevelSensor, GroundWithoutEndIsRefused) {
  World w(options_at(0.1));
  w.add(testing::ground(0.5));
  EXPECT_THROW(add_sensor(w, gauge("ground", 0, 0)), InputError);
}

}  // namespace
}  // namespace brim
