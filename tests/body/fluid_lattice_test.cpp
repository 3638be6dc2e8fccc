#include "brim/body/particle_fluid/fluid_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "brim/raster/shape.h"
#include "support/particle_fluids.h"

namespace brim::fluid_lattice_test {
namespace {

double filled(const FluidLattice& l) { return std::pow(l.spacing, 3) * static_cast<double>(l.x.size()); }

FluidLattice in_shape(const Shape& shape, double volume, double spacing) {
  return lattice_in_solid([&](const Vec3& x) { return shape.distance(x); }, shape.bounds(), volume, spacing);
}

TEST(FluidLattice, WholeSpacingsAreCubesExactly) {
  const double s = 0.04;
  const FluidLattice l = lattice_in_box(Vec3::Zero(), s * Vec3(3, 2, 4), s);
  EXPECT_EQ(l.spacing, s);
  ASSERT_EQ(l.x.size(), 24u);
  for (int k = 0, n = 0; k < 4; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 3; ++i, ++n) EXPECT_LT((l.x[n] - s * Vec3(i + 0.5, j + 0.5, k + 0.5)).norm(), 1e-15);
}

TEST(FluidLattice, FillsABoxOfAnySidesHalfACellFromItsFaces) {
  const unsigned seed = 5;
  SCOPED_TRACE(seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> side(0.3, 9.0);
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3 lo(0.1, -3, 2), size(side(rng), side(rng), side(rng));
    const FluidLattice l = lattice_in_box(lo, lo + size, 1.0);
    EXPECT_NEAR(filled(l), size.prod(), 1e-12 * size.prod());
    Aabb box;
    for (const Vec3& x : l.x) box.extend(x);
    for (int a = 0; a < 3; ++a) {
      const double n = std::max(1.0, std::round(size[a])), half = 0.5 * size[a] / n;
      EXPECT_NEAR(box.lo[a] - lo[a], half, 1e-12);
      EXPECT_NEAR(lo[a] + size[a] - box.hi[a], half, 1e-12);
    }
  }
}

TEST(FluidLattice, ParticlesInsideABoxOfHalfSpacingsAreFull) {
  const double s = testing::fluids::kSpacing;
  const FluidLattice l = lattice_in_box(Vec3::Zero(), s * Vec3(8.5, 11.5, 9.47), s);
  ParticleFluidOptions o;
  o.spacing = l.spacing;
  testing::fluids::Held held(l.x, o);
  const std::vector<double> fill = held.body.fill();
  // Unequal sides of cells change the sum in second order: 4e-4 where an axis of 8.5 spacings meets one of 9.
  EXPECT_NEAR(*std::max_element(fill.begin(), fill.end()), 1.0, 1e-3);
  EXPECT_NEAR(held.body.mass(), o.density * std::pow(s, 3) * 8.5 * 11.5 * 9.47, 1e-9);
}

TEST(FluidLattice, ASolidGetsItsVolumeFromParticlesNearTheSpacingInsideIt) {
  for (double r = 1.5; r < 8.0; r += 0.05) {
    const double volume = 4.0 / 3.0 * std::numbers::pi * r * r * r;
    const FluidLattice l = in_shape(*make_sphere(r), volume, 1.0);
    EXPECT_NEAR(filled(l), volume, 1e-12 * volume) << r;
    EXPECT_NEAR(l.spacing, 1.0, r < 3.0 ? 0.16 : 0.08) << r << ": whole shells are few in small balls";
    Vec3 middle = Vec3::Zero();
    for (const Vec3& x : l.x) {
      EXPECT_LT(x.norm(), 1.02 * r) << r;
      middle += x / static_cast<double>(l.x.size());
    }
    EXPECT_LT(middle.norm(), 1e-12) << "symmetric: equal depths stay together";
  }
}

TEST(FluidLattice, FlatEndsOfACylinderStayHalfACellFromTheLattice) {
  const double r = 5.2, length = 6.5, volume = std::numbers::pi * r * r * length;
  const FluidLattice l = in_shape(*make_cylinder(r, length), volume, 1.0);
  EXPECT_NEAR(filled(l), volume, 1e-12 * volume);
  Aabb box;
  for (const Vec3& x : l.x) box.extend(x);
  EXPECT_NEAR(0.5 * length - box.hi.z(), 0.5 * length / 7.0, 0.03);
  EXPECT_NEAR(0.5 * length + box.lo.z(), 0.5 * length / 7.0, 0.03);
}

TEST(FluidLattice, ABoxIsFilledAsASolidAsItIsAsABox) {
  const Vec3 size(2.3, 4.0, 1.2);
  const FluidLattice a = in_shape(*make_box(size), size.prod(), 1.0), b = lattice_in_box(-0.5 * size, 0.5 * size, 1.0);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.spacing, b.spacing);
}

TEST(FluidLattice, HasNoParticlesWhereNoCentreIsInside) {
  const auto outside = [](const Vec3&) { return 1.0; };
  EXPECT_TRUE(lattice_in_solid(outside, {Vec3::Zero(), Vec3::Ones()}, 0.1, 0.5).x.empty());
}

}  // namespace
}  // namespace brim::fluid_lattice_test
