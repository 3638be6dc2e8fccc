#include "brim/body/rigid/make_rigid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "brim/core/error.h"

namespace brim::testing::make_rigid_test {
namespace {

constexpr double kPi = std::numbers::pi;
/// Planes for the curved surface in cells of 1/128 of the size.
constexpr double kPlanes = 2.5e-4;

void expect_solid(const RigidModel& m, double volume, const Vec3& gyration, double tolerance) {
  EXPECT_NEAR(m.mass, 700.0 * volume, tolerance * m.mass);
  EXPECT_LT(m.center_of_mass.norm(), 1e-12);
  const Mat3 expected = m.mass * Mat3(gyration.asDiagonal());
  EXPECT_LT((m.inertia - expected).norm(), 2.0 * tolerance * expected.norm()) << m.inertia;
}

TEST(MakeRigid, BoxesHaveTheMassAndInertiaOfTheirFormulasToRounding) {
  const Vec3 e(0.3, 0.2, 0.05);
  const RigidModel m = make_rigid(make_box(e), 700.0, Vec3(1, 2, 3));
  const Vec3 s = e.cwiseAbs2();
  expect_solid(m, e.prod(), Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()) / 12.0,
               1e-10);  // rounding of two million sums
  EXPECT_EQ(m.position, Vec3(1, 2, 3));
  EXPECT_DOUBLE_EQ(m.part.voxel_size, 0.05 / 8.0);
  EXPECT_DOUBLE_EQ(m.part.thickness, 0.05);
  const double area = 2.0 * (e.x() * e.y() + e.y() * e.z() + e.x() * e.z());
  // Cells along edges are cut by one plane of the two.
  EXPECT_NEAR(m.part.areal_mass, 6.0 * m.mass / area, 0.05 * m.part.areal_mass);
}

TEST(MakeRigid, RoundSolidsHaveThoseOfTheirFormulasToSomeTenThousandths) {
  const double r = 0.1, l = 0.3;
  const RigidModel ball = make_rigid(make_sphere(r), 700.0);
  expect_solid(ball, 4.0 / 3.0 * kPi * r * r * r, Vec3::Constant(0.4 * r * r), kPlanes);
  EXPECT_NEAR(ball.part.areal_mass, 6.0 * ball.mass / (4.0 * kPi * r * r), 0.02 * ball.part.areal_mass);
  const double side = (3.0 * r * r + l * l) / 12.0;
  expect_solid(make_rigid(make_cylinder(r, l), 700.0), kPi * r * r * l, Vec3(side, side, 0.5 * r * r), kPlanes);
  // A capsule: the cylinder, and two half balls whose centres of mass are 3/8 r beyond its ends.
  const double vc = kPi * r * r * l, vs = 4.0 / 3.0 * kPi * r * r * r, v = vc + vs;
  const double across = (vc * side + vs * (0.4 * r * r + 0.25 * l * l + 0.375 * l * r)) / v;
  const double along = (vc * 0.5 + vs * 0.4) * r * r / v;
  expect_solid(make_rigid(make_capsule(r, l), 700.0), v, Vec3(across, across, along), kPlanes);
}

TEST(MakeRigid, WhatHasNoMassIsRefused) {
  const auto says = [](auto f, const std::string& part) {
    try {
      f();
      ADD_FAILURE() << "accepted: " << part;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  };
  says([] { make_rigid(nullptr, 1.0); }, "no shape");
  says([] { make_rigid(make_half_space(), 1.0); }, "no finite extent");
  for (const double density : {0.0, -1.0, std::nan("")})
    says([&] { make_rigid(make_sphere(0.1), density); }, "must be a number above 0");
}

}  // namespace
}  // namespace brim::testing::make_rigid_test
