#include "brim/world/free_flight.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "brim/body/articulated/articulated_body.h"
#include "brim/body/mass_spring/spring_mesh.h"
#include "brim/body/own/own_body.h"
#include "brim/body/points/points_body.h"
#include "brim/world/applied_force.h"
#include "brim/world/body_motion.h"
#include "support/carried.h"
#include "support/soft_worlds.h"

/// Bodies that nothing touches, against the parabola.
namespace brim::free_flight_test {
namespace {

constexpr double kStep = 1.0 / 60.0;
const Vec3 kGravity(0, 0, -9.81), kThrow(3, 1, 5), kSpin(0.5, -1.0, 2.0);

/// A ball that moves but does not turn, of coordinates of its own.
class Marble final : public OwnBody {
 public:
  explicit Marble(OwnModel m) : OwnBody(std::move(m)) {}
  std::string_view kind() const override { return "marble"; }
  Vec3 deform(Coordinates q, const Vec3& X) const override { return Vec3(q[0], q[1], q[2]) + X; }
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override { return x - Vec3(q[0], q[1], q[2]); }
  double distance(Coordinates q, const Vec3& x) const override { return inverse_deform(q, x).norm() - 0.1; }
};

std::unique_ptr<Body> marble() {
  OwnModel m;
  m.q = {0, 0, 0}, m.v = {0, 0, 0};
  m.surface = shapes::icosphere(0.1, 2);
  m.density = 500;
  return testing::named<Marble>("marble", std::move(m));
}

std::unique_ptr<Body> chain() {
  ArticulatedModel model;
  for (int i = 0; i < 3; ++i) {
    LinkModel l;
    l.name = "link" + std::to_string(i);
    l.parent = i - 1;
    l.joint.kind = i == 0 ? JointKind::Free : JointKind::Revolute;
    l.joint.position = Vec3(0.2, 0, 0), l.joint.axis = Vec3::UnitY();
    l.joint.start_velocity = i == 0 ? 0.0 : 1.0;
    l.mass = 1.0, l.inertia = 0.01 * Mat3::Identity();
    model.links.push_back(l);
  }
  return testing::named<ArticulatedBody>("chain", model);
}

/// One body of each kind that can be thrown.
std::vector<std::function<std::unique_ptr<Body>()>> kinds() {
  using namespace testing;
  const std::vector<Vec3> four{{0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}, {0, 0.098, 0.3}};
  PointsOptions grains;
  grains.radius = {0.05};
  return {[] { return box("box", {Vec3(0.1, 0.2, 0.3)}, 0.5, 0.3); },
          [] { return jelly("jelly", 0.5, Vec3(-0.25, -0.25, 0.0)); },
          [] { return sheet("sheet", 0.8, Vec3(0, 0, 0.5)); },
          [] { return springs("springs", 0.4, Vec3::Zero()); },
          [] { return rope("rope", Vec3(0, -0.5, 0), Vec3(0, 0.5, 0)); },
          [] { return blob("blob", 4, 0.1, Vec3::Zero()); },
          [=] { return named<PointsBody>("grains", four, grains); },
          [] { return meshless(Vec3::Constant(0.4), 0.13, 0.05, soft(1e5)); },
          [] { return voxels(Vec3::Constant(0.4), 0.13, 0.05, soft(1e5)); },
          [] { return chain(); },
          [] { return marble(); }};
}

TEST(FreeFlight, AThrownBodyOfEachKindLiesOnTheParabola) {
  for (const auto& make : kinds()) {
    World w(testing::options_at(0.05));
    std::unique_ptr<Body> made = make();
    SCOPED_TRACE(std::string(made->kind()));
    if (made->name().empty()) made->set_name("body");
    const int b = w.add(std::move(made));
    const bool turns = w.body(b).kind() != "marble";
    w.set_velocity(b, kThrow, turns ? kSpin : Vec3::Zero());
    const Vec3 start = *center_of_mass(w.body(b));
    double worst = 0.0;
    for (int s = 1; s <= 30; ++s) {
      w.step();
      const double t = s * kStep;
      const Vec3 fallen = *center_of_mass(w.body(b)) - start - t * kThrow - 0.5 * t * t * kGravity;
      worst = std::max(worst, fallen.norm());
    }
    RecordProperty(std::string(w.body(b).kind()), fmt::format("{:.1e}", worst));
    // Rods and fluids keep their momentum to 1e-8, and the momenta of trees and own bodies are known to that.
    const std::string_view kind = w.body(b).kind();
    const bool near = kind == "rod" || kind == "particle_fluid" || kind == "articulated" || kind == "marble";
    EXPECT_LT(worst, (near ? 1e-8 : 1e-12) * 2.5) << "of the 2.5 m that it is thrown";
  }
}

TEST(FreeFlight, KeepsTheEnergyOfAThrow) {
  World w(testing::options_at(0.05));
  w.add(testing::box("box", {Vec3(0, 0, 0), Quat::Identity(), kThrow}, 0.5, 0.3));
  const double start = 0.5 * 27.0 * kThrow.squaredNorm();
  for (int s = 0; s < 120; ++s) {
    const StepReport r = w.step();
    EXPECT_NEAR(r.kinetic_energy + r.potential_energy, start, 1e-12 * start);
  }
}

TEST(FreeFlight, AStraightRodThatSpinsGainsNoEnergy) {
  // About its own line it has hardly any inertia, and what was divided by that once grew to 1e10 J within ten steps.
  for (const int segments : {5, 20, 40}) {
    SCOPED_TRACE(segments);
    WorldOptions o = testing::options_at(0.05);
    o.environment.gravity.setZero();
    World w(o);
    std::vector<Vec3> nodes;
    for (int i = 0; i <= segments; ++i) nodes.emplace_back(double(i) / segments - 0.5, 0, 0);
    RodOptions rod;
    rod.radius = 0.02;
    const int b = w.add(testing::named<RodBody>("rod", nodes, rod));
    w.set_velocity(b, Vec3(0, 0, 2), Vec3(0, 0, 3));
    const double start = w.body(b).kinetic_energy(w.v(b));
    EXPECT_NEAR(start, 0.5 * 0.1 * 4.0 + 0.5 * (0.1 / 12.0) * 9.0, 0.05 * start);
    for (int s = 0; s < 60; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      ASSERT_LT(r.kinetic_energy + r.potential_energy, 1.0001 * start) << s;
    }
  }
}

/// A bow, a string, a ring and a net, loose enough to bend as they turn.
std::vector<std::unique_ptr<Body>> loose() {
  std::vector<std::unique_ptr<Body>> all;
  RodOptions rod;
  rod.radius = 0.02, rod.stiffness_damping = 0.005;
  std::vector<Vec3> bow, ring;
  for (int i = 0; i <= 20; ++i) bow.emplace_back(0.05 * i - 0.5, 0.0, 0.04 * (0.05 * i) * (1.0 - 0.05 * i));
  for (int i = 0; i < 24; ++i) ring.emplace_back(0.3 * std::cos(i * M_PI / 12), 0.3 * std::sin(i * M_PI / 12), 0.0);
  all.push_back(testing::named<RodBody>("bow", bow, rod));
  rod.bending = 0.0;
  all.push_back(testing::named<RodBody>("string", bow, rod));
  rod.bending = 1e-3, rod.closed = true;
  all.push_back(testing::named<RodBody>("ring", ring, rod));
  MassSpringOptions net;
  net.density = 0.1, net.stiffness = 1e4, net.thickness = 0.02, net.stiffness_damping = 0.005;
  all.push_back(testing::named<MassSpringBody>("net", square_net(8, 8, 0.6, 0.5), net));
  return all;
}

TEST(FreeFlight, LooseBodiesThatSpinGainNoEnergyAndKeepTheirMomentum) {
  // Parts that turn against the whole stretched their springs in second order: the net had seven times its energy.
  for (std::unique_ptr<Body>& made : loose()) {
    SCOPED_TRACE(made->name());
    WorldOptions o = testing::options_at(0.05);
    o.environment.gravity.setZero();
    World w(o);
    const int b = w.add(std::move(made));
    w.set_velocity(b, Vec3(1, 0, 2), Vec3(1, 2, 3));
    const auto spin = [&]() -> Vec3 {
      return w.body(b).angular_momentum(w.v(b)) - center_of_mass(w.body(b))->cross(w.body(b).linear_momentum(w.v(b)));
    };
    const Vec3 start = spin();
    double most = 0.0;
    for (int s = 0; s < 120; ++s) {
      const StepReport r = w.step();
      ASSERT_TRUE(r.ok);
      const double energy = r.kinetic_energy + r.potential_energy;
      if (s > 0) {
        ASSERT_LE(energy, most * (1 + 1e-9)) << s;
      }
      most = energy;
    }
    // About the line of a rod momentum is not kept (MeanMotion).
    EXPECT_LT((spin() - start).norm(), 2e-3 * start.norm());
  }
}

TEST(FreeFlight, LeavesWhatAForceOfPlaceHolds) {
  // An attractor as a spring: x + dt v⁺ keeps the energy of its swings in bounds, where the mean of velocities adds to
  // it.
  WorldOptions o = testing::options_at(0.05);
  o.environment.gravity.setZero();
  World w(o);
  const int b = w.add(testing::box("box", {Vec3(1, 0, 0)}, 0.5, 0.3));
  AppliedForce spring;
  spring.name = "spring";
  spring.attractor = AppliedForce::Attractor{Vec3::Zero(), 18.0, 2.0, 1.0};
  w.apply(spring);
  double most = 0.0;
  for (int s = 0; s < 600; ++s) {
    w.step();
    most = std::max(most, testing::position(w, b).norm());
  }
  EXPECT_LT(most, 1.01);
}

TEST(FreeFlight, BouncesNeverGainHeight) {
  for (const Response response : {Response::Penalty, Response::Constraint}) {
    WorldOptions o = testing::options_at(0.05);
    o.response = response;
    World w(o);
    w.add(testing::ground(0.5));
    RigidModel m;
    m.shape = make_sphere(0.2);
    m.mass = 1.0, m.inertia = 0.016 * Mat3::Identity();
    m.position = Vec3(0, 0, 0.7);
    m.part.material.restitution = 0.9;
    const int b = w.add(testing::named<RigidBody>("ball", m));
    double most = 9.81 * 0.7;
    for (int s = 0; s < 300; ++s) {
      const StepReport r = w.step();
      const double energy = r.kinetic_energy + r.potential_energy;
      if (r.contacts == 0) {
        EXPECT_LE(energy, most * (1 + 1e-9)) << s;
        most = std::min(most, energy);
      }
    }
    EXPECT_GT(testing::position(w, b).z(), 0.19);
  }
}

}  // namespace
}  // namespace brim::free_flight_test
