#include "brim/world/sense/contact_sensor.h"

#include <gtest/gtest.h>

#include "support/sensing.h"
#include "support/worlds.h"

/// Laws of contact events and impulses.
namespace brim {
namespace {

using namespace testing::sensing;

World bouncing(bool rows) {
  WorldOptions o = options_at(0.05);
  o.response = rows ? Response::Constraint : Response::Penalty;
  o.pair_materials[{"default", "default"}].restitution = 0.7;
  World w(o);
  w.add(ground(0.3));
  w.add(ball("ball", {Vec3(0, 0, 0.6), Quat::Identity(), Vec3(1, 0, -3)}, 0.3, 0.25));
  add_sensor(w, sensor_on(SensorKind::Contact, "ball"));
  return w;
}

TEST(ContactSensor, ImpulsesOfEveryStepAreTheChangeOfMomentum) {
  for (const bool rows : {false, true}) {
    World w = bouncing(rows);
    const double m = w.body(1).mass(), dt = w.options().time_step;
    int substeps = 0;
    for (int i = 0; i < 60; ++i) {
      const Vec3 before = velocity(w, 1);
      substeps += w.step().substeps;
      const Vec3 gained = m * (velocity(w, 1) - before - dt * Vec3(0, 0, -9.81));
      // Contacts are kept in single precision.
      EXPECT_LT((gained - reading_of_axes(w, "sensor", "impulse")).norm(), 2e-6 * m * 3.0) << i << rows;
    }
    EXPECT_GT(substeps, 60);  // some steps were divided
  }
}

TEST(ContactSensor, ABounceBeginsOnceAndEndsOnceWithItsImpulse) {
  World w = bouncing(true);
  Sensors& sensors = sensors_of(w);
  sensors.begin_frame();
  const double m = w.body(1).mass();
  for (int i = 0; i < 20; ++i) w.step();
  const auto events = sensors.frame_events();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_TRUE(events[0].began);
  EXPECT_FALSE(events[1].began);
  EXPECT_EQ(w.body(events[1].body_a).name(), "ball");
  EXPECT_EQ(w.body(events[1].body_b).name(), "ground");
  EXPECT_DOUBLE_EQ(events[1].time - events[0].time, events[1].duration);
  // Free fall from 0.35 m above contact at 3 m/s.
  const double hit = std::sqrt(9.0 + 2 * 9.81 * 0.35);
  EXPECT_NEAR(events[0].time, (hit - 3.0) / 9.81, 0.02);
  EXPECT_NEAR(events[1].impulse.z(), 1.7 * m * hit, 0.05 * m * hit);
}

TEST(ContactSensor, APauseWithinTheGapDoesNotEndAContact) {
  World w = bouncing(true);
  SensorModel patient = sensor_on(SensorKind::Contact, "ball", "patient");
  patient.gap = 2.0;
  add_sensor(w, patient);
  double began = 0, patiently = 0;
  for (int i = 0; i < 90; ++i) {
    w.step();
    began += reading(w, "sensor", "began"), patiently += reading(w, "patient", "began");
  }
  EXPECT_GT(began, 1);
  EXPECT_EQ(patiently, 1);
  EXPECT_EQ(reading(w, "patient", "touching"), 1);
}

TEST(ContactSensor, ARestoredStateGoesOnWithWhatTouchesInIt) {
  World w = bouncing(true);
  SensorModel patient = sensor_on(SensorKind::Contact, "ball", "patient");
  patient.gap = 0.02;
  add_sensor(w, patient);
  while (reading(w, "sensor", "touching") == 0) w.step();
  const State saved = w.state();
  const auto listen_to = [](World& world) {
    sensors_of(world).begin_frame();
    for (int i = 0; i < 60; ++i) world.step();
    std::vector<double> all;
    for (const ContactEvent& e : sensors_of(world).frame_events())
      all.insert(all.end(), {double(e.sensor), double(e.began), e.time, e.duration, e.impulse.z(), e.peak});
    return all;
  };
  const auto first = listen_to(w);
  World other = bouncing(true);
  add_sensor(other, patient);
  other.set_state(saved);
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(listen_to(other), first);
  EXPECT_EQ(other.hash(), w.hash());
}

TEST(ContactSensor, LighterTouchesThanTheLeastForceAreNone) {
  World w = bouncing(false);
  SensorModel deaf = sensor_on(SensorKind::Contact, "ball", "deaf");
  deaf.least_force = 1e9;
  add_sensor(w, deaf);
  for (int i = 0; i < 20; ++i) {
    w.step();
    EXPECT_EQ(reading(w, "deaf", "touching"), 0);
  }
}

}  // namespace
}  // namespace brim
