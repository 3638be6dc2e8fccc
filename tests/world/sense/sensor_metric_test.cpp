#include "brim/world/sense/sensor_metric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "brim/core/error.h"
#include "support/sensing.h"
#include "support/worlds.h"

namespace brim {
namespace {

World sensed_ball() {
  World w(testing::options_at(0.1));
  w.add(testing::ball("ball", {Vec3(0, 0, 5)}));
  add_sensor(w, testing::sensor_on(SensorKind::Motion, "ball", "probe"));
  return w;
}

Expectation asks(const std::string& take, bool ratio = false) {
  Expectation e;
  e.metric = "sensor", e.take = take, e.reading = {"probe", "velocity_z"};
  if (ratio) e.over = {"probe", "speed"};
  return e;
}

double over(const SensorMetric& metric, const std::vector<SensorMetric::Pair>& frames) {
  SensorMetric::Fold fold = metric.fold();
  for (const SensorMetric::Pair& frame : frames) fold.add(frame);
  return fold.value();
}

TEST(SensorMetric, TakesReadingsOverAWindow) {
  const World w = sensed_ball();
  const std::vector<SensorMetric::Pair> values = {{5, 1}, {-1, 1}, {2, 4}, {3, 2}};
  EXPECT_EQ(over(SensorMetric(w, asks("mean")), values), 9.0 / 4);
  EXPECT_EQ(over(SensorMetric(w, asks("sum")), values), 4.0);
  EXPECT_EQ(over(SensorMetric(w, asks("last")), values), 3.0);
  EXPECT_EQ(over(SensorMetric(w, asks("least")), values), -1.0);
  EXPECT_EQ(over(SensorMetric(w, asks("largest")), values), 5.0);
  EXPECT_EQ(over(SensorMetric(w, asks("mean", true)), values), 9.0 / 8);
}

TEST(SensorMetric, NotANumberDoesNotHide) {
  const World w = sensed_ball();
  const std::vector<SensorMetric::Pair> values = {{5, 1}, {std::numeric_limits<double>::quiet_NaN(), 1}, {2, 1}};
  for (const char* take : {"mean", "sum", "least", "largest"})
    EXPECT_TRUE(std::isnan(over(SensorMetric(w, asks(take)), values))) << take;
}

TEST(SensorMetric, ReadsTheLastFrameAndRefusesWhatIsNotThere) {
  World w = sensed_ball();
  w.step();
  EXPECT_NEAR(SensorMetric(w, asks("last", true)).now(w)[0], -9.81 / 60, 1e-12);
  Expectation e = asks("last");
  e.reading.channel = "colour";
  EXPECT_THROW(SensorMetric(w, e), InputError);
  e.reading.sensor = "nothing";
  EXPECT_THROW(SensorMetric(w, e), InputError);
}

}  // namespace
}  // namespace brim
