#include <gtest/gtest.h>

#include <cmath>

#include "brim/body/points/points_body.h"
#include "brim/world/applied_force.h"
#include "brim/world/body_motion.h"
#include "support/soft_worlds.h"
#include "support/solids.h"
#include "support/worlds.h"

/// Coulomb's law under penalties: what is inside of the cone sticks soon, what is outside of it slides by the
/// difference.
namespace brim::friction_test {
namespace {

using testing::box;
using testing::ground;
using testing::options_at;
using testing::run;
using testing::velocity;

/// Down the fall of a plane of a given angle, and away from it.
struct Slope {
  double angle;
  Vec3 down() const { return {std::cos(angle), 0.0, -std::sin(angle)}; }
  Vec3 normal() const { return {std::sin(angle), 0.0, std::cos(angle)}; }
};

/// A box on a slope. @return its speed down after some time, [m/s]
double slide(const Slope& slope, double friction, double start, double seconds) {
  World w(options_at(0.125));
  w.add(ground(friction, slope.normal()));
  testing::Start s;
  s.x = 0.5 * slope.normal();
  s.rotation = Quat::FromTwoVectors(Vec3::UnitZ(), slope.normal());
  s.v = start * slope.down();
  const int b = w.add(box("box", s, friction));
  run(w, seconds);
  return slope.down().dot(velocity(w, b));
}

TEST(Friction, ABoxThatSlidesSlowlyInsideTheConeStopsAsCoulombSays) {
  const Slope slope{25.0 * M_PI / 180.0};
  for (const double mu : {0.5, 0.55, 0.7}) {
    // Stops after v/(g (µ cos − sin)); five steps later it creeps no faster than regularised friction lets it.
    const double stop = 0.1 / (9.81 * (mu * std::cos(slope.angle) - std::sin(slope.angle)));
    EXPECT_LT(slide(slope, mu, 0.1, stop + 5.0 / 60.0), 2e-4) << mu;
  }
}

TEST(Friction, ABoxJustOutsideOfTheConeSlidesFromRestByTheDifference) {
  for (const double degrees : {20.0, 25.0, 30.0}) {
    const Slope slope{degrees * M_PI / 180.0};
    const double mu = 0.9 * std::tan(slope.angle), speed = 9.81 * 0.1 * std::sin(slope.angle);
    EXPECT_NEAR(slide(slope, mu, 0.0, 1.0), speed, 0.15 * speed) << degrees;
  }
}

TEST(Friction, GrainsInsideTheConeStickAsSoonAsTheyAreDown) {
  const Slope slope{25.0 * M_PI / 180.0};
  World w(options_at(0.02));
  w.add(ground(0.55, slope.normal()));
  std::vector<Vec3> centers;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j)
      centers.push_back(0.06 * i * slope.down() + Vec3(0.0, 0.06 * j, 0.0) + 0.02 * slope.normal());
  PointsOptions o;
  o.radius = {0.02};
  o.turn = false;  // round ones would roll
  o.material.friction = 0.55;
  auto grains = std::make_unique<PointsBody>(centers, o);
  grains->set_name("grains");
  const int b = w.add(std::move(grains));
  run(w, 0.15);
  for (std::size_t i = 0; i + 2 < w.v(b).size(); i += 3)
    EXPECT_LT(Vec3(w.v(b)[i], w.v(b)[i + 1], w.v(b)[i + 2]).norm(), 1e-3) << i / 3;
}

TEST(Friction, OfABlockThatSpreadsUnderItsWeightIsThatOfItsLoad) {
  // The middle of its face sticks while the rim slides outward: friction of one slip for all would be far off.
  WorldOptions options = options_at(0.05);
  options.time_step = 0.01;
  World w(options);
  const double mu = 0.2;
  w.add(ground(mu));
  FemOptions o;
  o.young = 1e5, o.material.friction = mu;
  w.add(testing::named<FemBody>("block", testing::block_at(6, 0.6, Vec3(-0.3, -0.3, 0.01)), o));
  double worst = 0.0;
  int beyond = 0;
  constexpr int kSteps = 60;
  for (int i = 0; i < kSteps; ++i) {
    w.step();
    double load = 0.0, friction = 0.0;
    for (const ContactSample& c : w.contacts()) load += c.force.norm(), friction += c.friction.norm();
    if (!(load > 0.0)) continue;
    worst = std::max(worst, friction / (mu * load));
    beyond += friction > 1.05 * mu * load;
  }
  EXPECT_LT(worst, 1.4);
  EXPECT_LE(beyond, kSteps / 10);
}

TEST(Friction, SheetsThatLieInEachOtherWithoutWeightPart) {
  // Nothing moves and nothing weighs: friction has no speed to go by but the one that it is told.
  WorldOptions o = testing::options_at(0.05);
  o.environment.gravity = Vec3::Zero();
  World w(o);
  w.add(testing::sheet("one", 0.8, Vec3::Zero()));
  w.add(testing::sheet("two", 0.8, Vec3(0.0, 0.0, 0.08)));
  for (int s = 0; s < 20; ++s) ASSERT_TRUE(w.step().ok) << s;
  EXPECT_GT(w.q(1)[2] - w.q(0)[2], 0.09);
}

TEST(Friction, LiftsWhatAWallThatRisesHolds) {
  // Pressed by twice its weight in friction: it leaves the floor, which must not hold it back.
  constexpr double kRise = 0.03;
  for (const bool soft : {false, true}) {
    SCOPED_TRACE(soft ? "soft" : "rigid");
    WorldOptions o = options_at(0.01);
    o.response = Response::Penalty;
    World w(o);
    w.add(ground(0.5));
    ObstacleModel wall;
    wall.shape = make_box(Vec3(0.1, 0.4, 1.0));
    const Vec3 at(-0.1, 0, 0.3);
    wall.keys = {{0.0, at}, {1.0, at + Vec3(0, 0, kRise)}};
    w.add(testing::named<ObstacleBody>("wall", wall));
    const int b = w.add(soft ? testing::jelly("body", 0.1, Vec3(-0.05, -0.05, 0.0))
                             : box("body", {Vec3(0, 0, 0.05)}, 0.5, 0.1, 500.0));
    AppliedForce press;
    press.name = "press", press.bodies = {"body"}, press.acceleration = Vec3(-40.0, 0.0, 0.0);
    w.apply(press);
    const double start = center_of_mass(w.body(b))->z();
    run(w, 1.0);
    EXPECT_NEAR(center_of_mass(w.body(b))->z() - start, kRise, soft ? 0.006 : 0.001);
  }
}

}  // namespace
}  // namespace brim::friction_test
