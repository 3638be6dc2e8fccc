#include "brim/world/contact_parameters.h"

#include <gtest/gtest.h>

#include "brim/body/fem/fem_body.h"
#include "support/soft_worlds.h"
#include "support/solids.h"
#include "support/worlds.h"

/// Warnings of contact that cannot hold what it is given.
namespace brim::contact_parameters_test {
namespace {

using testing::box;
using testing::ground;
using testing::options_at;

int warnings_of(World& w, const std::string& code, int steps) {
  int said = 0;
  for (int s = 0; s < steps; ++s)
    for (const Warning& warning : w.step().warnings) said += warning.code == code;
  return said;
}

/// Of that stiffness, [Pa]; 0: chosen.
World on_ground(double stiffness) {
  WorldOptions o = options_at(0.125);
  o.stiffness = stiffness;
  World w(o);
  w.add(ground(0.5));
  return w;
}

TEST(ContactParameters, AContactThirtyTimesStifferThanItsLoadsAskForIsTold) {
  const auto said = [](double stiffness) {
    World w = on_ground(stiffness);
    FemOptions options;
    options.young = 1e5;
    w.add(std::make_unique<FemBody>(testing::block(2, 2, 2, 0.25), options));
    return warnings_of(w, "stiff_contact", 3);
  };
  EXPECT_EQ(said(0.0), 0);
  EXPECT_EQ(said(2e6), 0) << "twenty times the modulus, as it would be chosen";
  EXPECT_GE(said(1e10), 1);
}

/// Two boxes of 64 kg fall onto each other and the ground, 1.6e7 Pa chosen: 1e9 Pa takes their energy from 1.1 to 12
/// kJ.
TEST(ContactParameters, AGigapascalBetweenRigidBoxesIsTold) {
  const auto said = [](double stiffness) {
    World w = on_ground(stiffness);
    w.add(box("lower", {Vec3(0, 0, 0.6)}, 0.5, 0.4));
    w.add(box("upper", {Vec3(0.05, 0.02, 1.2)}, 0.5, 0.4));
    return warnings_of(w, "stiff_contact", 3);
  };
  EXPECT_EQ(said(0.0), 0);
  EXPECT_EQ(said(1e9), 1);
}

TEST(ContactParameters, APairOfMaterialsThatIsTooStiffIsToldOnce) {
  WorldOptions o = options_at(0.125);
  o.pair_materials[{"default", "default"}].stiffness = 1e11;
  World w(o);
  w.add(ground(0.5));
  w.add(box("box", {Vec3(0, 0, 0.5)}));
  EXPECT_EQ(warnings_of(w, "stiff_contact", 3), 1);
}

TEST(ContactParameters, ARestitutionThatPenaltiesDoNotHaveIsToldOnce) {
  const auto said = [](double restitution, Response response) {
    WorldOptions o = options_at(0.125);
    o.response = response;
    o.pair_materials[{"default", "default"}].restitution = restitution;
    World w(o);
    w.add(ground(0.5));
    w.add(testing::ball("ball", {Vec3(0, 0, 2)}));
    return warnings_of(w, "no_restitution", 3);
  };
  EXPECT_EQ(said(0.0, Response::Penalty), 0);
  EXPECT_EQ(said(0.8, Response::Penalty), 1);
  EXPECT_EQ(said(0.8, Response::Constraint), 0);
}

TEST(ContactParameters, ARestitutionOfADeformableBodyIsToldOnce) {
  const auto said = [](double soft, double rigid, double pair, Response response) {
    WorldOptions o = options_at(0.125);
    o.response = Response::Inherit;
    o.pair_materials[{"hard", "soft"}].restitution = pair;
    World w(o);
    RigidModel hard;
    hard.shape = make_sphere(0.25);
    hard.mass = 1.0, hard.inertia = 0.025 * Mat3::Identity(), hard.position = Vec3(0, 0, 2);
    hard.part.material.name = "hard", hard.part.material.restitution = rigid;
    w.add(testing::named<RigidBody>("ball", hard));
    FemOptions jelly;
    jelly.young = 1e5;
    jelly.material.name = "soft", jelly.material.restitution = soft, jelly.material.response = response;
    w.add(testing::named<FemBody>("jelly", testing::block(2, 2, 2, 0.25), jelly));
    return warnings_of(w, "no_restitution", 3);
  };
  EXPECT_EQ(said(0.0, 0.8, -1.0, Response::Inherit), 0) << "the ball's own, which has an effect on the floor";
  EXPECT_EQ(said(0.8, 0.0, -1.0, Response::Inherit), 1);
  EXPECT_EQ(said(0.0, 0.0, 0.8, Response::Inherit), 1) << "of the pair";
  EXPECT_EQ(said(0.8, 0.0, -1.0, Response::Constraint), 0) << "rows have one";
}

/// Warnings of a box of some mass on one of 1 kg, in half a second.
int mass_warnings(double mass, Response response) {
  WorldOptions o = options_at(0.125);
  o.response = response;
  World w(o);
  w.add(ground(0.5));
  w.add(box("light", {Vec3(0, 0, 0.5)}, 0.5, 1.0, 1.0));
  w.add(box("heavy", {Vec3(0.05, 0.03, 1.5)}, 0.5, 1.0, mass));
  return warnings_of(w, "mass_ratio", 30);
}

TEST(ContactParameters, AMassRatioThatRowsDoNotHoldIsTold) {
  EXPECT_GT(mass_warnings(1e4, Response::Constraint), 0);
  EXPECT_EQ(mass_warnings(100.0, Response::Constraint), 0);
  EXPECT_EQ(mass_warnings(1e4, Response::Penalty), 0) << "penalties hold it";
}

TEST(ContactParameters, ALightBoxOnAHeavyOneIsNotTold) {
  WorldOptions o = options_at(0.125);
  o.response = Response::Constraint;
  World w(o);
  w.add(ground(0.5));
  w.add(box("heavy", {Vec3(0, 0, 0.5)}, 0.5, 1.0, 1e4));
  w.add(box("light", {Vec3(0.05, 0.03, 1.5)}, 0.5, 1.0, 1.0));
  EXPECT_EQ(warnings_of(w, "mass_ratio", 30), 0);
}

}  // namespace
}  // namespace brim::contact_parameters_test
