#include "brim/mesh/areal_mass.h"

#include <gtest/gtest.h>

namespace brim::areal_mass_test {
namespace {

constexpr double kDensity = 1000.0;

/// A bundle of straight wires of square section a through a cube of side L.
double bundle(int wires, double a, double L, double h) {
  const double volume = wires * a * a * L, surface = wires * (4.0 * a * L + 2.0 * a * a);
  return areal_mass(kDensity * volume, volume, surface, {Vec3::Zero(), Vec3::Constant(L)}, h);
}

TEST(ArealMass, OfACubeIsTheMassOfItsLength) {
  const double L = 0.4;
  EXPECT_NEAR(areal_mass(kDensity * L * L * L, L * L * L, 6 * L * L, {Vec3::Zero(), Vec3::Constant(L)}, 0.01),
              kDensity * L, 1e-9);
}

TEST(ArealMass, OfWiresThinnerThanTheRampIsThatOfTheirOutlineHoweverManyThereAre) {
  const double L = 0.4, a = 0.004;
  for (const int wires : {1, 10, 100}) EXPECT_NEAR(bundle(wires, a, L, 0.004), kDensity * L, 1e-9) << wires;
}

TEST(ArealMass, GoesOverFromWiresToSolidAsVoxelsGetFiner) {
  const double L = 0.4, a = 0.02, thickness = 1.5 * a;  // 6 V / A of a long wire
  const double solid = bundle(5, a, L, thickness / 10.0);
  EXPECT_NEAR(solid, kDensity * thickness, 0.05 * kDensity * thickness);
  double last = solid;
  for (const double voxels : {6.0, 5.0, 4.0, 3.0, 1.0}) {
    const double now = bundle(5, a, L, thickness / voxels);
    EXPECT_GE(now, last * (1.0 - 1e-12)) << voxels;
    last = now;
  }
  EXPECT_NEAR(last, kDensity * L, 1e-9);
}

}  // namespace
}  // namespace brim::areal_mass_test
