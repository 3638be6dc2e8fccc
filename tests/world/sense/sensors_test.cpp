#include "brim/world/sense/sensors.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/world/attachment.h"
#include "support/sensing.h"
#include "support/soft_worlds.h"

/// Laws of all sensors together.
namespace brim {
namespace {

using namespace testing::sensing;

World sensed_world() {
  World w = testing::soft_world_in_rain();
  add_sensor(w, sensor_on(SensorKind::Force, "ground", "plate"));
  add_sensor(w, sensor_on(SensorKind::Contact, "*", "touches"));
  SensorModel map = sensor_on(SensorKind::Pressure, "ground", "map");
  map.grid = SensorModel::Grid{Vec3(-1, -1, 0), Vec3(3, 0, 0), Vec3(0, 2, 0), 30, 20};
  add_sensor(w, map);
  SensorModel half = sensor_on(SensorKind::Force, "jelly", "half");
  half.region = [](const Vec3& x) { return x.x() > 0.0; };
  add_sensor(w, half);
  return w;
}

TEST(Sensors, ReadTheSameBitsForAnyNumberOfThreads) {
  std::vector<std::vector<double>> all;
  for (const int n : {1, 3}) {
    const ThreadLimit limit(n);
    World w = sensed_world();
    std::vector<double> seen;
    for (int i = 0; i < 20; ++i) {
      w.step();
      for (std::size_t s = 0; s < find_sensors(w)->size(); ++s) {
        for (const double x : find_sensors(w)->values(s)) seen.push_back(std::isnan(x) ? -1.0 : x);
        seen.insert(seen.end(), find_sensors(w)->map(s).begin(), find_sensors(w)->map(s).end());
      }
    }
    all.push_back(seen);
  }
  EXPECT_EQ(all[0], all[1]);
}

TEST(Sensors, ChangeNothingOfTheMotion) {
  World w = sensed_world(), plain = testing::soft_world_in_rain();
  for (int i = 0; i < 20; ++i) w.step(), plain.step();
  EXPECT_EQ(w.state().q, plain.state().q);
  EXPECT_EQ(w.state().v, plain.state().v);
}

TEST(Sensors, APlateUnderBodiesThatSleepGoesOnReadingTheirWeight) {
  WorldOptions o = options_at(0.1);
  o.sleep = true;
  const auto make = [&] {
    World w(o);
    w.add(ground(0.5));
    for (int i = 0; i < 2; ++i) w.add(box("box." + std::to_string(i), {Vec3(0, 0, 0.25 + 0.5 * i)}, 0.5, 0.5, 400));
    add_sensor(w, sensor_on(SensorKind::Force, "ground", "plate"));
    add_sensor(w, sensor_on(SensorKind::Contact, "box", "touches"));
    return w;
  };
  World w = make();
  run(w, 3.0);
  ASSERT_TRUE(w.asleep(1));
  const double weight = 2 * 400 * 0.125 * 9.81;
  EXPECT_NEAR(reading(w, "plate", "force_z"), -weight, 0.01 * weight);
  EXPECT_EQ(reading(w, "touches", "touching"), 2);
  // A run that is resumed while they sleep reads the same.
  World other = make();
  other.set_state(w.state());
  w.step(), other.step();
  EXPECT_EQ(reading(other, "plate", "force_z"), reading(w, "plate", "force_z"));
  EXPECT_EQ(reading(other, "touches", "duration"), reading(w, "touches", "duration"));
}

TEST(Sensors, OfAStateThatIsSetReadThatState) {
  World w(options_at(0.1));
  w.add(ground(0.5));
  w.add(testing::ball("ball", {Vec3(0, 0, 0.6)}));
  add_sensor(w, sensor_on(SensorKind::Force, "ground", "plate"));
  const State start = w.state();
  const double before = reading(w, "plate", "force_z");
  run(w, 0.5);
  ASSERT_LT(reading(w, "plate", "force_z"), -100.0);
  w.set_state(start);
  EXPECT_EQ(reading(w, "plate", "force_z"), before);
}

TEST(Sensors, ReadingsOfAFrameAreThoseOfItsSteps) {
  World w(options_at(0.1));
  w.add(ground(0.5));
  w.add(testing::ball("ball", {Vec3(0, 0, 0.6)}));
  SensorModel plate = sensor_on(SensorKind::Force, "ground", "plate");
  plate.every_step = true;
  add_sensor(w, plate);
  Sensors& s = sensors_of(w);
  for (int frame = 0; frame < 10; ++frame) {
    s.begin_frame();
    double mean = 0.0, sum = 0.0, most = 0.0;
    for (int i = 0; i < 4; ++i) {
      w.step();
      mean += 0.25 * reading(w, "plate", "force_z"), sum += reading(w, "plate", "impulse_z");
      most = std::max(most, reading(w, "plate", "peak"));
    }
    const auto at = [&](const char* channel) {
      return s.frame(0).values[static_cast<std::size_t>(s.channel(0, channel))];
    };
    EXPECT_NEAR(at("force_z"), mean, 1e-9 * std::abs(mean));
    EXPECT_NEAR(at("impulse_z"), sum, 1e-9 * std::abs(sum));
    EXPECT_EQ(at("peak"), most);
    ASSERT_EQ(s.frame(0).rows.size(), 4 * (1 + s.sensor(0).channels().size()));
    EXPECT_DOUBLE_EQ(s.frame(0).rows[0], (4 * frame + 1) / 60.0);
  }
  s.end_frames();
  w.step();
  EXPECT_TRUE(s.frame(0).rows.empty());
  EXPECT_EQ(s.frame(0).values[2], reading(w, "plate", "force_z"));
}

TEST(Sensors, AnAttachmentReadsWhatItCarries) {
  World w(options_at(0.1));
  w.add(box("box", {Vec3(0, 0, 1)}));
  Attachment pin;
  pin.name = "pin", pin.body = "box", pin.point = Vec3(0, 0, 1.5);
  w.attach(pin);
  SensorModel m;
  m.name = "load", m.kind = SensorKind::Link, m.link = "pin";
  add_sensor(w, m);
  run(w, 1.0);
  EXPECT_NEAR(reading(w, "load", "force_z"), 9810, 10);
  m.name = "other", m.link = "nothing";
  EXPECT_THROW(add_sensor(w, m), InputError);
}

TEST(Sensors, ListenersAreCalledAfterEveryStep) {
  World w(options_at(0.1));
  w.add(ground(0.5));
  w.add(testing::ball("ball", {Vec3(0, 0, 0.55)}));
  add_sensor(w, sensor_on(SensorKind::Contact, "ball", "touches"));
  int calls = 0, began = 0;
  sensors_of(w).listen([&](const World& world, const Sensors& s) {
    ++calls;
    for (const ContactEvent& e : s.events()) began += e.began && world.body(e.body_a).name() == "ball";
  });
  for (int i = 0; i < 30; ++i) w.step();
  EXPECT_EQ(calls, 30);
  EXPECT_GE(began, 1);
}

TEST(Sensors, NamesThatAreMissingOrTwiceAreRefused) {
  World w(options_at(0.1));
  w.add(ground(0.5));
  add_sensor(w, sensor_on(SensorKind::Force, "ground"));
  EXPECT_THROW(add_sensor(w, sensor_on(SensorKind::Force, "ground")), InputError);
  EXPECT_THROW(add_sensor(w, sensor_on(SensorKind::Force, "nobody", "other")), InputError);
  EXPECT_THROW(add_sensor(w, sensor_on(SensorKind::Force, "ground", "")), InputError);
}

TEST(Sensors, ReadNothingOfABodyThatWasRemoved) {
  World w(options_at(0.1));
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0, 0, 0.5)}));
  add_sensor(w, sensor_on(SensorKind::Force, "ground", "plate"));
  add_sensor(w, sensor_on(SensorKind::Contact, "box", "touches"));
  add_sensor(w, sensor_on(SensorKind::Motion, "box", "probe"));
  run(w, 1.0);
  EXPECT_EQ(reading(w, "touches", "touching"), 1);
  w.remove(1);
  w.step();
  EXPECT_EQ(reading(w, "plate", "force_z"), 0.0);
  EXPECT_EQ(reading(w, "touches", "ended"), 1);
  EXPECT_TRUE(std::isnan(reading(w, "probe", "position_z")));
}

TEST(Sensors, FollowBodiesThatAreAddedLater) {
  World w(options_at(0.1));
  w.add(ground(0.5));
  add_sensor(w, sensor_on(SensorKind::Force, "ground", "plate"));
  w.step();
  w.add(box("box", {Vec3(0, 0, 0.5)}));
  run(w, 1.0);
  EXPECT_NEAR(reading(w, "plate", "force_z"), -9810, 98.1);
}

}  // namespace
}  // namespace brim
