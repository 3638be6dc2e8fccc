#include "brim/world/measures.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "brim/mesh/primitives.h"
#include "brim/world/display_measures.h"
#include "brim/world/report_fields.h"
#include "support/worlds.h"

namespace brim::measures_test {
namespace {

using testing::box;
using testing::ground;
using testing::options_at;

constexpr double kStep = 1.0 / 60.0;

Expectation asked(const std::string& metric, const std::string& body = "", double from = 0.0,
                  double to = std::numeric_limits<double>::infinity()) {
  Expectation e;
  e.metric = metric;
  e.body = body;
  e.from = from;
  e.to = to;
  e.min = 0.0;
  return e;
}

/// A ball that shows itself, as bodies of scenes do.
std::unique_ptr<Body> shown_ball(std::string name, const Vec3& x, const Vec3& v) {
  RigidModel m;
  m.shape = make_sphere(0.5);
  m.surface = shapes::icosphere(0.5);
  m.mass = 500.0;
  m.inertia = 50.0 * Mat3::Identity();
  m.position = x, m.velocity = v;
  auto b = std::make_unique<RigidBody>(m);
  b->set_name(std::move(name));
  return b;
}

/// Two balls apart in free space, one at rest, one that flies along x at 2 m/s.
World two_balls(const Vec3& gravity = Vec3::Zero()) {
  WorldOptions o = options_at(0.125);
  o.environment.gravity = gravity;
  World w(o);
  w.add(shown_ball("still", Vec3(0, 5, 0), Vec3::Zero()));
  w.add(shown_ball("flying", Vec3(1, 0, 3), Vec3(2, 0, 0)));
  return w;
}

/// Steps a world and asks. @return what became of each
std::vector<ExpectationResult> measured(World& w, const std::vector<Expectation>& expect, int steps) {
  Measures m(w, expect, steps * kStep);
  m.add(w, {}, 0);
  for (int s = 0; s < steps; ++s) {
    const StepReport r = w.step();
    m.add(w, r, 1);
  }
  return m.findings();
}

TEST(Measures, WayAndSpeedAreThoseOfTheMotion) {
  World w = two_balls();
  const auto f = measured(w,
                          {asked("displacement_x", "flying"), asked("drift", "flying"), asked("speed", "flying"),
                           asked("speed_kept", "flying"), asked("acceleration", "flying"), asked("front", "flying"),
                           asked("displacement", "", 0.5), asked("position_z", "flying")},
                          60);
  EXPECT_NEAR(f[0].value, 2.0, 1e-9);
  EXPECT_NEAR(f[1].value, 2.0, 1e-6) << "displays are of single precision";
  EXPECT_NEAR(f[2].value, 2.0, 1e-9);
  EXPECT_NEAR(f[3].value, 1.0, 1e-9);
  EXPECT_NEAR(f[4].value, 0.0, 1e-9);
  EXPECT_NEAR(f[5].value, 3.5, 0.01) << "1 m, 2 m of flight and the radius";
  EXPECT_NEAR(f[6].value, 0.0, 1e-9) << "of all bodies the one nearest to its bound, 0, speaks";
  EXPECT_EQ(f[6].body, "still");
  EXPECT_NEAR(f[7].value, 3.0, 1e-6);
}

TEST(Measures, ABodyThatTurnsBackDriftsFartherThanItEnds) {
  World w = two_balls(Vec3(-4, 0, 0));
  // x = 2 t - 2 t²: back after a second, and half a metre away in between.
  const auto f = measured(w, {asked("drift", "flying"), asked("displacement", "flying")}, 60);
  EXPECT_NEAR(f[0].value, 0.5, 0.04) << "first order in the step";
  EXPECT_LT(f[1].value, 0.05);
}

TEST(Measures, MomentumOfAllBodiesChangesByTheImpulseOfWeight) {
  World w = two_balls(Vec3(0, 0, -9.81));
  const double mass = w.body(0).mass() + w.body(1).mass();
  const auto f = measured(
      w, {asked("momentum_change"), asked("momentum_change", "", 0.5, 1.0), asked("angular_momentum_change")}, 60);
  EXPECT_NEAR(f[0].value, mass * 9.81, 1e-6 * mass);
  EXPECT_NEAR(f[1].value, 0.5 * mass * 9.81, 1e-6 * mass);
  // About the origin: still at y = 5, flying at x = 1 to 3, a weight of m g each.
  const double m = w.body(0).mass();
  EXPECT_NEAR(f[2].value, m * 9.81 * std::hypot(5.0, 2.0), 0.01 * m * 9.81 * 5.0);
}

TEST(Measures, ContactOfABoxAtRestCarriesTheImpulseOfItsWeight) {
  World w(options_at(0.125));
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0, 0, 0.5)}));
  const auto f = measured(w, {asked("impulse_z", "box", 1.0, 2.0), asked("contact_force_z", "box", 1.0, 2.0)}, 120);
  const double weight = w.body(1).mass() * 9.81;
  EXPECT_NEAR(f[0].value, weight * 1.0, 0.01 * weight);
  EXPECT_NEAR(f[1].value, weight, 0.01 * weight);
}

// A fast blow within a step of several sub-steps: the last one alone says little of it.
TEST(Measures, ImpulseOfABlowIsTheChangeOfMomentum) {
  WorldOptions o = options_at(0.125);
  o.environment.gravity = Vec3::Zero();
  o.time_step = kStep;
  World w(o);
  w.add(ground(0.5));
  w.add(shown_ball("ball", Vec3(0, 0, 1.2), Vec3(0, 0, -30.0)));
  Measures m(w, {asked("impulse_z", "ball"), asked("contact_force_z", "ball", kStep)}, 8 * kStep);
  m.add(w, {}, 0);
  const double before = w.body(1).linear_momentum(w.v(1)).z();
  int most = 0;
  for (int frame = 0; frame < 4; ++frame) {
    StepReport sum;  // of two steps
    for (int s = 0; s < 2; ++s) {
      StepReport r = w.step();
      most = std::max(most, r.substeps);
      accumulate(sum, std::move(r));
    }
    m.add(w, sum, 2);
  }
  const double change = w.body(1).linear_momentum(w.v(1)).z() - before;
  EXPECT_GT(most, 2);
  EXPECT_GT(change, 0.5 * std::abs(before));
  const auto f = m.findings();
  EXPECT_NEAR(f[0].value, change, 1e-6 * change);
  EXPECT_NEAR(f[1].value, change / (8 * kStep), 1e-6 * change / kStep);
}

TEST(Measures, EnergyThatGrowsAfterAFallIsSeenThoughItNeverPassesTheStart) {
  World w = two_balls();
  Measures m(w, {asked("energy_rise"), asked("energy_growth"), asked("max_speed")}, 4.0);
  m.add(w, {}, 0);
  for (const double energy : {10.0, 4.0, 7.0, 6.0}) {
    StepReport r;
    r.kinetic_energy = energy;
    r.max_speed = energy;
    r.time = w.state().time;
    m.add(w, r, 1);
  }
  const auto f = m.findings();
  EXPECT_EQ(f[0].value, 0.0);
  EXPECT_EQ(f[1].value, 3.0);
  EXPECT_EQ(f[2].value, 10.0);
}

TEST(Measures, WhatIsNotANumberHoldsNoBound) {
  World w = two_balls();
  Measures m(w, {asked("kinetic_energy"), asked("energy_growth")}, 0.0);
  StepReport r;
  r.kinetic_energy = std::numeric_limits<double>::quiet_NaN();
  m.add(w, {}, 0);
  m.add(w, r, 1);
  for (const ExpectationResult& f : m.findings()) EXPECT_FALSE(f.ok) << f.expectation.metric;
}

TEST(Measures, AWindowThatTheRunDidNotReachHoldsNoBound) {
  World w = two_balls();
  Measures m(w, {asked("speed", "flying"), asked("speed", "flying", 0.0, 0.5)}, 10.0);
  m.add(w, {}, 0);
  for (int s = 0; s < 60; ++s) {
    const StepReport r = w.step();
    m.add(w, r, 1);
  }
  const auto f = m.findings();
  EXPECT_FALSE(f[0].reached || f[0].ok) << "it ends at 10 s";
  EXPECT_TRUE(f[1].reached && f[1].ok);
}

/// Of a ball that is thrown up, every window of frames gives what all its frames together give.
TEST(Measures, AWindowHasTheFramesThatLieInIt) {
  constexpr int kSteps = 30;
  const std::pair<int, int> windows[] = {{0, kSteps}, {0, 0}, {7, 7}, {1, 12}, {10, 25}, {29, 30}};
  for (const auto& [from, to] : windows) {
    SCOPED_TRACE(from);
    World w(options_at(0.125));
    w.add(shown_ball("ball", Vec3(0, 0, 3), Vec3(0, 0, 2)));
    const double first = from * kStep, last = to * kStep;
    Measures m(w,
               {asked("highest", "ball", first, last), asked("position_z", "ball", first, last),
                asked("displacement_z", "ball", first, last), asked("max_speed", "", first, last),
                asked("failed_steps", "", first, last)},
               kSteps * kStep);
    std::vector<double> highest, z, speed;
    StepReport report;
    for (int f = 0; f <= kSteps; ++f) {
      if (f > 0) report = w.step();
      m.add(w, report, f > 0);
      highest.push_back(m.samples()[0].highest), z.push_back(m.samples()[0].center.z());
      speed.push_back(report.max_speed);
    }
    const auto most = [&](const std::vector<double>& x) {
      return *std::max_element(x.begin() + from, x.begin() + to + 1);
    };
    const auto found = m.findings();
    const auto at = [](const std::vector<double>& x, int f) { return x[static_cast<std::size_t>(f)]; };
    EXPECT_EQ(found[0].value, most(highest));
    EXPECT_EQ(found[1].value, at(z, to));
    EXPECT_EQ(found[2].value, at(z, to) - at(z, from));
    EXPECT_EQ(found[3].value, most(speed));
    EXPECT_EQ(found[4].value, 0.0);
    for (const ExpectationResult& f : found) EXPECT_TRUE(f.reached);
  }
}

TEST(Measures, AKnownMissIsAsExpectedOnlyWhileItMisses) {
  World w = two_balls();
  Expectation met = asked("speed", "flying"), missed = met;
  met.known_miss = missed.known_miss = "a figure and its cause";
  missed.min = 3.0;
  const auto f = measured(w, {met, missed, asked("speed", "flying")}, 1);
  EXPECT_TRUE(f[0].ok && !f[0].as_expected());
  EXPECT_TRUE(!f[1].ok && f[1].as_expected());
  EXPECT_TRUE(f[2].ok && f[2].as_expected());
}

TEST(Measures, AKnownMissIsAsExpectedOnlyUpToItsWorst) {
  World w = two_balls();
  Expectation below = asked("speed", "flying"), above = below;
  below.known_miss = above.known_miss = "a figure and its cause";
  const double speed = measured(w, {asked("speed", "flying")}, 1)[0].value;
  below.min = speed + 2.0, above.max = speed - 2.0;
  for (const double off : {1.0, -1.0}) {
    World again = two_balls();
    below.known_worst = speed - off, above.known_worst = speed + off;
    const auto f = measured(again, {below, above}, 1);
    EXPECT_EQ(f[0].as_expected(), off > 0.0);
    EXPECT_EQ(f[1].as_expected(), off > 0.0);
    EXPECT_EQ(f[1].worse(), off < 0.0);
  }
}

TEST(Measures, CopiesOfABodyAreConcernedAndNoOthers) {
  EXPECT_TRUE(concerns("box", "box") && concerns("box", "box.12"));
  for (const char* other : {"box.", "box.1a", "boxes", "bo", "a box"}) EXPECT_FALSE(concerns("box", other)) << other;
}

/// A square of two triangles at a height, and four points around its middle.
Shown sheet_at(float z, float size = 1.0f) {
  return {{{-size, -size, z}, {size, -size, z}, {size, size, z}, {-size, size, z}}, {{0, 1, 2}, {0, 2, 3}}, 0.0};
}

Shown cube(double side) {
  const auto s = static_cast<float>(side);
  Shown c;
  for (int i = 0; i < 8; ++i) c.x.emplace_back(i & 1 ? s : 0.0f, i & 2 ? s : 0.0f, i & 4 ? s : 0.0f);
  c.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return c;
}

TEST(DisplayMeasures, VolumeInsideACubeIsItsSideCubedWhereverItLies) {
  Shown c = cube(2.0);
  EXPECT_NEAR(enclosed_volume(c), 8.0, 1e-9);
  for (Vec3f& x : c.x) x += Vec3f(10, -20, 30);
  EXPECT_NEAR(enclosed_volume(c), 8.0, 1e-9);
  EXPECT_TRUE(std::isnan(enclosed_volume({{Vec3f(0, 0, 0)}, {}, 0.1}))) << "points enclose nothing";
}

TEST(DisplayMeasures, PointsUnderASheetAreThoseBelowAllOfIt) {
  Shown points{{{0, 0.1f, -1}, {0.1f, 0, 1}, {5, 0, -1}, {0.3f, 0.2f, -0.01f}}, {}, 0.0};
  EXPECT_EQ(count_under(points, sheet_at(0)), 2);
  Shown folded = sheet_at(0);
  const Shown lower = sheet_at(-0.5f);
  for (const Triangle& t : lower.triangles) folded.triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
  folded.x.insert(folded.x.end(), lower.x.begin(), lower.x.end());
  EXPECT_EQ(count_under(points, folded), 1) << "between the layers is not below";
}

TEST(DisplayMeasures, TheLevelOfAPoolIsThatOfMostColumnsAwayFromWhatFloats) {
  // Ten columns by ten, 0.3 m high but where something stands on the seven in the middle of each row.
  Shown pool{{}, {}, 0.05};
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j)
      for (int k = 0; k < 3; ++k)
        pool.x.emplace_back(0.1f * static_cast<float>(i) + 0.05f, 0.1f * static_cast<float>(j) + 0.05f,
                            0.1f * static_cast<float>(k) + (i > 1 && i < 9 ? 5.05f : 0.05f));
  EXPECT_NEAR(surface_level(pool, vertex_spacing(pool)), 5.3, 1e-6) << "without it these are most";
  const Shown floating{{{0.3f, 0, 0}, {0.8f, 1, 1}}, {}, 0.0};
  EXPECT_NEAR(surface_level(pool, vertex_spacing(pool), &floating), 0.3, 1e-6);
  pool.x.emplace_back(0.05f, 0.05f, 9.0f);  // a drop above it
  EXPECT_NEAR(surface_level(pool, vertex_spacing(pool), &floating), 0.3, 1e-6);
  const Shown lid{{{0, 0, 0}, {1, 1, 0}}, {}, 0.0};
  EXPECT_TRUE(std::isnan(surface_level(pool, vertex_spacing(pool), &lid))) << "no free column is left";
}

}  // namespace
}  // namespace brim::measures_test
