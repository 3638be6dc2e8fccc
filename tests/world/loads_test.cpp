#include "brim/world/loads.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/body/fem/fem_body.h"
#include "support/solids.h"
#include "support/worlds.h"

namespace brim::loads_test {
namespace {

using testing::box;
using testing::ground;

constexpr double kGravity = 9.81;

/// Bodies as a world numbers them.
struct Scene {
  std::vector<std::unique_ptr<Body>> bodies;
  std::vector<WorldPart> parts;
  std::vector<double> speed;

  void add(std::unique_ptr<Body> b, double v = 0.0) {
    std::vector<double> q(b->q_size()), qd(b->v_size());
    b->initial_state(q, qd);
    b->update(0.0, q, qd);
    parts.push_back({b.get(), static_cast<int>(bodies.size()), 0, 0.125, b->part(0)});
    speed.push_back(v);
    bodies.push_back(std::move(b));
  }
  std::vector<Loads> of_parts(const Vec3& gravity = Vec3(0, 0, -kGravity)) const {
    return estimate_loads(parts, speed, {gravity});
  }
  Loads loads(const Vec3& gravity = Vec3(0, 0, -kGravity)) const {
    Loads heaviest;
    for (const Loads& l : of_parts(gravity)) heaviest.raise_to(l);
    return heaviest;
  }
};

TEST(Loads, OneBoxByHand) {
  Scene s;
  s.add(ground(0.5));
  s.add(box("box", {Vec3(0, 0, 1.5)}));
  const Loads l = s.loads();
  EXPECT_NEAR(l.areal_mass, 1000.0, 1e-9);
  EXPECT_NEAR(l.pressure, 1000.0 * kGravity, 1e-6);
  EXPECT_NEAR(l.impact_energy, 1000.0 * 2 * kGravity * 1.0, 1e-6);
}

TEST(Loads, WhatStandsFallsOnlyAsFarAsItCanTopple) {
  const auto impact = [](const Vec3& size) {
    Scene s;
    s.add(ground(0.5));
    RigidModel m;
    m.shape = make_box(size);
    m.mass = 1000.0 * size.prod();
    m.inertia = m.mass * Mat3::Identity();
    m.position = Vec3(0, 0, 0.5 * size.z());
    s.add(std::make_unique<RigidBody>(m));
    return s.loads();
  };
  EXPECT_NEAR(impact(Vec3(1, 1, 1)).impact_energy, 0.0, 1e-6) << "a cube lies as flat as it can";
  EXPECT_NEAR(impact(Vec3(4, 3, 1)).impact_energy, 0.0, 1e-6) << "so does a plank";
  const Loads tower = impact(Vec3(0.2, 0.3, 2));
  EXPECT_NEAR(tower.impact_energy, tower.areal_mass * 2 * kGravity * 0.9, 1e-6) << "its middle from 1 m to 0.1 m";
}

TEST(Loads, AColumnWeighsWhatItsBoxesWeigh) {
  Scene s;
  s.add(ground(0.5));
  for (int i = 0; i < 10; ++i) s.add(box("box" + std::to_string(i), {Vec3(0, 0, 0.5 + i)}));
  s.add(box("apart", {Vec3(20, 0, 0.5)}));
  EXPECT_NEAR(s.loads().pressure, 10 * 1000.0 * kGravity, 1e-6);
}

TEST(Loads, EachPartHasItsOwnAndTheWeightAboveIt) {
  Scene s;
  s.add(ground(0.5));
  s.add(box("below", {Vec3(0, 0, 0.5)}));
  s.add(box("above", {Vec3(0, 0, 2.5)}, 0.5, 1.0, 3000.0));
  s.add(box("apart", {Vec3(20, 0, 1.0)}, 0.5, 1.0, 10.0));
  const std::vector<Loads> l = s.of_parts();
  EXPECT_EQ(l[0].pressure + l[0].areal_mass + l[0].impact_energy, 0.0) << "the ground";
  EXPECT_NEAR(l[1].pressure, 4000.0 * kGravity, 1e-6);
  EXPECT_NEAR(l[2].pressure, 3000.0 * kGravity, 1e-6);
  EXPECT_NEAR(l[3].pressure, 10.0 * kGravity, 1e-9);
  EXPECT_NEAR(l[1].areal_mass, 1000.0, 1e-9);
  EXPECT_NEAR(l[2].impact_energy, 3000.0 * 2 * kGravity * 2.0, 1e-6);
  EXPECT_NEAR(l[3].impact_energy, 10.0 * 2 * kGravity * 0.5, 1e-9);
}

TEST(Loads, DependOnGravitysDirectionOnlyThroughTheScene) {
  // The same scene turned: down is x.
  Scene upright, turned;
  upright.add(ground(0.5));
  turned.add(ground(0.5, Vec3(-1, 0, 0)));
  for (int i = 0; i < 3; ++i) {
    upright.add(box("box" + std::to_string(i), {Vec3(0.1 * i, 0.2, 0.7 + i)}));
    turned.add(box("box" + std::to_string(i), {Vec3(-0.7 - i, 0.2, 0.1 * i)}));
  }
  const Loads a = upright.loads(), b = turned.loads(Vec3(kGravity, 0, 0));
  EXPECT_NEAR(a.pressure, b.pressure, 1e-6);
  EXPECT_NEAR(a.areal_mass, b.areal_mass, 1e-9);
  EXPECT_NEAR(a.impact_energy, b.impact_energy, 1e-6);
}

TEST(Loads, SpeedCountsAsImpact) {
  Scene s;
  s.add(box("box", {}), 30.0);
  EXPECT_NEAR(s.loads(Vec3::Zero()).impact_energy, 1000.0 * 900.0, 1e-6);
  EXPECT_EQ(s.loads(Vec3::Zero()).pressure, 0.0);
}

TEST(Loads, ASceneOfObstaclesHasNone) {
  Scene s;
  s.add(ground(0.5));
  const Loads l = s.loads();
  EXPECT_EQ(l.pressure + l.areal_mass + l.impact_energy, 0.0);
  EXPECT_EQ(choose_stiffness(l, 0.3, 0.01), 0.0);
}

TEST(Loads, StiffnessIsTheLargestOfItsThreeNeeds) {
  const double w = 0.375, dt = 1.0 / 60;
  EXPECT_DOUBLE_EQ(choose_stiffness({100.0, 0.0, 0.0}, w, dt), 2e5);
  EXPECT_DOUBLE_EQ(choose_stiffness({0.0, 0.0, 300.0}, w, dt), 8 * 300.0 / w);
  EXPECT_DOUBLE_EQ(choose_stiffness({0.0, 10.0, 0.0}, w, dt), 4 * 10.0 * w / (1.2 * dt * dt));
  EXPECT_DOUBLE_EQ(choose_stiffness({100.0, 10.0, 300.0}, w, dt), 2e5);
}

TEST(Loads, ContactIsStifferThanTheBodiesThatItPressesWhateverTheyWeigh) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double E : {1e3, 1e6, 1e9})
    EXPECT_GE(soften_stiffness(1e4, E, Loads{}, 0.1, 1e-2), kContactModulus * E)
        << "a scene without loads has a small k";
  EXPECT_EQ(soften_stiffness(1e7, inf, Loads{}, 0.1, 1e-2), 1e7) << "between rigid bodies the loads alone tell";
  const Loads heavy{1e5, 1e3, 0.0};
  EXPECT_GE(soften_stiffness(2e8, 1.0, heavy, 0.1, 1e-2), 100.0 * heavy.pressure) << "soft bodies must carry loads too";
}

TEST(Loads, ContactOfStiffBodiesIsBoundedByHowFarTheyMoveInAStep) {
  const double m = 40.0, w = 0.09, dt = 0.01, k = 1e5, voxel = w / 3.0;  // kg/m², m, s, Pa, m
  const auto at = [&](double motion, double E) {
    const double v = motion * voxel / dt;
    return soften_stiffness(k, E, Loads{0.0, m, m * v * v}, w, dt);
  };
  for (const double motion : {0.0, 0.1, 0.2}) EXPECT_DOUBLE_EQ(at(motion, 1e11), kMostOfSlow * k) << motion;
  EXPECT_NEAR(at(0.5, 1e11), 4.0 * kMostOfFast * k, 1e-6 * k);
  EXPECT_DOUBLE_EQ(at(1.0, 1e11), kMostOfFast * k);
  EXPECT_DOUBLE_EQ(at(0.5, 1e5), kContactModulus * 1e5) << "soft bodies as before";
  // What stops an impact within a voxel is kept.
  EXPECT_DOUBLE_EQ(at(30.0, 1e11), std::max(kMostOfFast * k, 8.0 * m * std::pow(30.0 * voxel / dt, 2) / w));
}

TEST(Loads, ASceneThatMakesContactSofterThanItsBodiesIsToldOnce) {
  const auto codes = [](double stiffness) {
    WorldOptions o = testing::options_at(0.05);
    o.stiffness = stiffness;
    World w(o);
    w.add(ground(0.5));
    FemOptions options;
    options.young = 2e5;
    auto soft = std::make_unique<FemBody>(testing::block(2, 2, 2, 0.1), options);
    soft->set_name("soft");
    w.add(std::move(soft));
    int said = 0;
    for (int s = 0; s < 3; ++s)
      for (const Warning& warning : w.step().warnings) said += warning.code == "soft_contact";
    return said;
  };
  EXPECT_EQ(codes(1e5), 1);
  EXPECT_EQ(codes(1e7), 0);
  EXPECT_EQ(codes(0.0), 0);
}

}  // namespace
}  // namespace brim::loads_test
