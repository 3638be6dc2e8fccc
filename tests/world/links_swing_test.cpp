#include <gtest/gtest.h>

#include <limits>

#include "brim/world/attachment.h"
#include "brim/world/links.h"
#include "support/joints.h"
#include "support/worlds.h"

/// Solids that swing on joints: their energy, and the sub-steps that they need (links_swing.cpp, links_arcs.cpp,
/// leapfrog.h).
namespace brim::links_swing_test {
namespace {

using testing::box;
using testing::joint;
using testing::options_at;
using testing::run;
using testing::velocity;

constexpr double kGravity = 9.81;

TEST(LinkJoints, LightSolidsCarryHeavyOnesWithoutSwinging) {
  for (const int most : {64, 1}) {
    WorldOptions o = options_at(0.05);
    o.max_substeps = most;
    World w(o);
    const int n = 8;
    bool told = false, capped = false;
    for (int i = 0; i <= n; ++i) {
      const std::string name = "box" + std::to_string(i);
      testing::Start start;
      start.x = Vec3(0, 0, 2.0 - 0.2 * i), start.v = Vec3(1e-3, 0, 0);
      w.add(box(name, start, 0.5, 0.1, i < n ? 1000.0 : 50e3));
      Attachment a =
          joint(JointKind::Ball, name, i > 0 ? "box" + std::to_string(i - 1) : "", Vec3(0, 0, 2.1 - 0.2 * i));
      a.name += std::to_string(i);
      w.attach(a);
    }
    double energy = 0.0;
    for (int s = 0; s < 240; ++s) {
      const StepReport r = w.step();
      energy = r.kinetic_energy;
      for (const Warning& warning : r.warnings) {
        told |= warning.code == "link_apart";
        capped |= warning.code == "substeps_capped" && warning.message.find("pull hard") != std::string::npos;
      }
    }
    EXPECT_EQ(capped, most == 1);
    EXPECT_EQ(energy<0.1, most> 1) << energy;
    EXPECT_EQ(told, most == 1) << "one sub-step is too long, and is told to be";
  }
}

/// A chain of n links of 0.2 kg with a weight of 50 kg, which moves at 2 m/s.
World light_chain(int n) {
  WorldOptions o = options_at(0.0075);
  o.response = Response::Constraint;
  World w(o);
  const double length = 0.16;
  for (int i = 0; i <= n; ++i) {
    const bool weight = i == n;
    RigidModel m;
    m.shape = weight ? make_sphere(0.2) : make_capsule(0.03, 0.1);
    m.mass = weight ? 50.0 : 0.2;
    m.inertia = weight ? Vec3(0.8, 0.8, 0.8).asDiagonal() : Vec3(4.7e-4, 4.7e-4, 9e-5).asDiagonal();
    m.position = Vec3(0, 0, -length * i - (weight ? 0.2 : 0.5 * length));
    auto link = std::make_unique<RigidBody>(m);
    link->set_name("link" + std::to_string(i));
    w.add(std::move(link));
    Attachment a = joint(JointKind::Ball, "link" + std::to_string(i), i > 0 ? "link" + std::to_string(i - 1) : "",
                         Vec3(0, 0, -length * i));
    a.name += std::to_string(i);
    w.attach(a);
  }
  w.set_velocity(n, Vec3(2, 0, 0), Vec3::Zero());
  return w;
}

/// The pull of a swinging chain rises and falls within a step. Sub-steps that became longer and shorter with it fed the
/// swing of its light links: 20 of them gained 815 J.
TEST(LinkJoints, ALightChainWithAHeavyEndGainsNoEnergy) {
  for (const int n : {10, 20}) {
    World w = light_chain(n);
    const StepReport start = w.present();
    double most = -std::numeric_limits<double>::infinity(), least = 0.0;
    for (int s = 0; s < 300; ++s) {
      const StepReport r = w.step();
      const double gained = r.kinetic_energy + r.potential_energy - start.kinetic_energy - start.potential_energy;
      most = std::max(most, gained), least = std::min(least, gained);
    }
    EXPECT_LT(most, 0.0) << n << " links; the weight has 100 J";
    EXPECT_GT(least, -5.0) << n << " links";
  }
}

TEST(LinkJoints, SubstepsOfASwingingChainAreTheSameFromItsState) {
  World w = light_chain(10);
  run(w, 1.0);
  const State state = w.state();
  World other = light_chain(10);
  other.set_state(state);
  for (int s = 0; s < 30; ++s) ASSERT_EQ(w.step().substeps, other.step().substeps) << "step " << s;
  EXPECT_EQ(w.state().q, other.state().q);
}

TEST(LinkJoints, SubstepsAreLongAgainOnceAllLinksAreGone) {
  World w = light_chain(10);
  w.set_velocity(10, Vec3::Zero(), Vec3::Zero());
  run(w, 0.2);
  EXPECT_GT(w.step().substeps, 2);
  for (int i = 0; i <= 10; ++i) w.detach(i);
  w.step();
  EXPECT_EQ(w.step().substeps, 1);
}

/// A bridge of planks between two fixed hinges, straight at first: nothing holds it across until it has sagged, and
/// then its pull is large. What the fall stretched comes back as speed where shorter sub-steps close it.
TEST(LinkJoints, AStraightBridgeSagsAndGainsNoEnergy) {
  for (const int n : {5, 7, 9}) {
    World w(options_at(0.025));
    const auto x_of = [&](int i) { return 0.3 * (i - 0.5 * n); };
    for (int i = 0; i < n; ++i) {
      RigidModel m;
      m.shape = make_box(Vec3(0.25, 1.0, 0.05));
      m.mass = 5.0;
      m.inertia = m.mass / 12.0 * Vec3(1.0025, 0.065, 1.0625).asDiagonal();
      m.position = Vec3(x_of(i) + 0.15, 0, 0);
      auto plank = std::make_unique<RigidBody>(m);
      plank->set_name("plank" + std::to_string(i));
      w.add(std::move(plank));
    }
    for (int i = 0; i <= n; ++i) {
      const std::string name = "plank" + std::to_string(std::min(i, n - 1));
      Attachment a = joint(JointKind::Revolute, name, i > 0 && i < n ? "plank" + std::to_string(i - 1) : "",
                           Vec3(x_of(i), 0, 0), Vec3(0, 1, 0));
      a.name += std::to_string(i);
      w.attach(a);
    }
    double most = -std::numeric_limits<double>::infinity(), apart = 0.0;
    StepReport r;
    for (int s = 0; s < 120; ++s) {
      r = w.step();
      ASSERT_TRUE(r.ok) << n << " planks";
      most = std::max(most, r.kinetic_energy + r.potential_energy);
      for (const LinkReport& link : r.links) apart = std::max(apart, link.error);
    }
    EXPECT_LT(most, 0.01) << n << " planks; the start has 0 J";
    EXPECT_LT(apart, 0.01) << n << " planks";
  }
}

/// A bob, or a body of any inertia, on a joint at the origin, which is beside its middle.
RigidModel on_joint(const Vec3& middle, const Vec3& inertia, const Vec3& velocity, const Vec3& spin) {
  RigidModel m;
  m.shape = make_sphere(0.05);
  m.mass = 1.0;
  m.inertia = inertia.asDiagonal();
  m.position = middle, m.velocity = velocity, m.angular_velocity = spin;
  return m;
}

double energy(const StepReport& r) { return r.kinetic_energy + r.potential_energy; }

/// Sub-steps of a swing are shorter where it is fast. Gravity over the new length alone took a part of the energy at
/// every change: 1.4 J of a bob's 2.5 in 20 s.
TEST(LinkJoints, ABobSwingsAsHighAfterManySubstepsOfTwoLengths) {
  WorldOptions o = options_at(0.02);
  o.time_step = 1.0 / 60.0;
  World w(o);
  w.add(std::make_unique<RigidBody>(
      on_joint(Vec3(std::sqrt(0.75), 0, -0.5), Vec3::Constant(1e-3), Vec3::Zero(), Vec3::Zero())));
  Attachment pivot = joint(JointKind::Revolute, w.body(0).name(), "", Vec3::Zero(), Vec3(0, 1, 0));
  w.attach(pivot);
  const double start = energy(w.present());
  int least = 100, most = 0;
  for (int s = 0; s < 1200; ++s) {
    const StepReport r = w.step();
    least = std::min(least, r.substeps), most = std::max(most, r.substeps);
    ASSERT_NEAR(energy(r), start, 0.15) << "step " << s;
  }
  EXPECT_LT(least, most);  // what this test is about
}

/// Two bars of 1 m and 1 kg, released level: the tips reach 7 m/s. Joints whose ends move straight within a sub-step
/// lost 4.3 J in 10 s at 1/60 s.
TEST(LinkJoints, ADoublePendulumKeepsItsEnergyInOneSubstep) {
  WorldOptions o = options_at(0.025);
  o.time_step = 1.0 / 60.0;
  World w(o);
  for (int i = 0; i < 2; ++i) {
    RigidModel m;
    m.shape = make_box(Vec3(0.9, 0.05, 0.05));
    m.mass = 1.0, m.inertia = Vec3(4.2e-4, 0.0677, 0.0677).asDiagonal();
    m.position = Vec3(0.5 + i, 0, 0);
    auto bar = std::make_unique<RigidBody>(m);
    bar->set_name("bar" + std::to_string(i));
    w.add(std::move(bar));
    Attachment a =
        joint(JointKind::Revolute, "bar" + std::to_string(i), i > 0 ? "bar0" : "", Vec3(i, 0, 0), Vec3(0, 1, 0));
    a.name += std::to_string(i);
    w.attach(a);
  }
  const double start = energy(w.present());
  for (int s = 0; s < 600; ++s) {
    const StepReport r = w.step();
    ASSERT_EQ(r.substeps, 1);
    ASSERT_NEAR(energy(r), start, 0.8) << "step " << s;  // the second bar falls by up to 20 J
    for (const LinkReport& l : r.links) ASSERT_LT(l.error, 2e-3);
  }
}

/// A gyroscope of 56 J on a joint beside it: more than a radian in a sub-step would be more than a solve can follow.
TEST(LinkJoints, AGyroscopeOnAJointKeepsItsEnergy) {
  for (const double spin : {20.0, 50.0, 150.0}) {
    WorldOptions o = options_at(0.02);
    o.time_step = 1.0 / 60.0;
    World w(o);
    const double l = 0.15, turn = kGravity * l / (5e-3 * spin);  // [rad/s] of precession
    w.add(std::make_unique<RigidBody>(
        on_joint(Vec3(l, 0, 0), Vec3(5e-3, 2.5e-3, 2.5e-3), Vec3(0, l * turn, 0), Vec3(spin, 0, turn))));
    w.attach(joint(JointKind::Ball, w.body(0).name(), "", Vec3::Zero()));
    const double start = energy(w.present());
    for (int s = 0; s < 240; ++s) {
      const StepReport r = w.step();
      ASSERT_GE(r.substeps, spin * r.dt / Links::kSpin - 1e-6);
      ASSERT_NEAR(energy(r), start, 0.15) << spin << " rad/s, step " << s;
    }
  }
}

TEST(LinkJoints, ASpinThatNeedsMoreSubstepsThanAllowedIsToldOf) {
  WorldOptions o = options_at(0.02);
  o.time_step = 1.0 / 60.0, o.max_substeps = 2;
  World w(o);
  w.add(std::make_unique<RigidBody>(
      on_joint(Vec3(0.15, 0, 0), Vec3(5e-3, 2.5e-3, 2.5e-3), Vec3::Zero(), Vec3(150, 0, 0))));
  w.attach(joint(JointKind::Ball, w.body(0).name(), "", Vec3::Zero()));
  const StepReport r = w.step();
  ASSERT_FALSE(r.warnings.empty());
  EXPECT_EQ(r.warnings[0].code, "substeps_capped");
  EXPECT_NE(r.warnings[0].message.find("spin by more than 1 rad in each of the 2 sub-steps"), std::string::npos)
      << r.warnings[0].message;
}

/// What rests on something presses on it by its weight, whatever the lengths of sub-steps: gravity over the mean of two
/// lengths would be more or less.
TEST(LinkJoints, AWeightOnAFloorPressesByItsWeightWhenSubstepsChange) {
  WorldOptions o = options_at(0.05);
  o.time_step = 1.0 / 60.0, o.response = Response::Penalty;
  World w(o);
  w.add(testing::ground(0.5));
  w.add(box("weight", {Vec3(0, 0, 0.5), Quat::Identity()}));
  Attachment slider = joint(JointKind::Prismatic, "weight", "", Vec3(0, 0, 0.5));
  w.attach(slider);
  RigidModel wheel;
  wheel.shape = make_sphere(0.1), wheel.mass = 1.0, wheel.inertia = 4e-3 * Mat3::Identity();
  wheel.position = Vec3(20, 0, 20);
  const int spun = w.add(std::make_unique<RigidBody>(wheel));
  Attachment axle = joint(JointKind::Revolute, w.body(spun).name(), "", wheel.position);
  axle.name = "axle";
  w.attach(axle);
  run(w, 0.5);
  for (const double turns : {0.0, 4.0, 0.0, 8.0, 0.0}) {
    w.set_velocity(spun, Vec3::Zero(), Vec3(0, 0, turns * 60.0));
    const StepReport r = w.step();
    EXPECT_GE(r.substeps, turns) << "what this test is about";
    ASSERT_EQ(r.pairs.size(), 1u);
    EXPECT_NEAR(r.pairs[0].force_on_a.norm(), 1000.0 * kGravity, 0.02 * 1000.0 * kGravity) << turns;
  }
}

}  // namespace
}  // namespace brim::links_swing_test
