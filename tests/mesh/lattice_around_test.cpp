#include "brim/mesh/lattice_around.h"

#include <gtest/gtest.h>

#include <random>

#include "brim/core/error.h"
#include "brim/mesh/mass_properties.h"

namespace brim::lattice_around_test {
namespace {

constexpr unsigned kSeed = 6;

TEST(LatticeAround, EveryPointIsInsideItsTetrahedron) {
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  std::vector<Vec3> points;
  for (int i = 0; i < 500; ++i) points.push_back(Vec3(u(rng), 0.3 * u(rng), 0.02 * u(rng)));
  const HeldPoints held = lattice_around(points, 0.2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec3 x = Vec3::Zero();
    double sum = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const double w = held.embedding.weights[i][k];
      EXPECT_GE(w, -1e-9) << "seed " << kSeed << ", point " << i;
      sum += w;
      x += w * held.mesh.vertices[held.mesh.tets[held.embedding.tet[i]][k]];
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    EXPECT_LT((x - points[i]).norm(), 1e-12);
  }
}

TEST(LatticeAround, OnePointTakesOneTetrahedronOfTheLattice) {
  const std::vector<Vec3> point = {Vec3(0.31, -0.2, 5.0)};
  const HeldPoints held = lattice_around(point, 0.1);
  ASSERT_EQ(held.mesh.tets.size(), 1u);
  ASSERT_EQ(held.mesh.vertices.size(), 4u);
  // Twelve to a cube, and all alike.
  const auto& x = held.mesh.vertices;
  EXPECT_NEAR(tet_volume(x[0], x[1], x[2], x[3]), 1e-3 / 12.0, 1e-12);
}

TEST(LatticeAround, CubesOfMatterAreHeldWithoutGapsAndWithLittleMore) {
  std::vector<Vec3> points;
  for (int k = 0; k < 20; ++k)
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i) points.push_back(0.05 * Vec3(i + 0.5, j + 0.5, k + 0.5));
  const std::vector<std::uint8_t> whole(points.size(), 1);
  const TetMesh mesh = lattice_around(points, 0.1, 0.05, whole).mesh;
  // Whatever lies deeper than a tetrahedron is held.
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> u(0.1, 0.9);
  std::vector<Vec3> inside;
  for (int i = 0; i < 3000; ++i) inside.push_back(Vec3(u(rng), u(rng), u(rng)));
  EXPECT_LT(embed(mesh, inside).farthest, 1e-9);
  const MassProperties m = mass_properties(mesh, 1.0);
  EXPECT_LT(m.volume, std::pow(1.2, 3));
  EXPECT_LT((m.center - Vec3::Constant(0.5)).norm(), 0.02);
  EXPECT_LT(mass_properties(lattice_around(points, 0.1).mesh, 1.0).volume, 0.5) << "points alone leave gaps";
}

TEST(LatticeAround, WhatIsHeldAndWhatLiesOutsideMakeTheCubesTogether) {
  // One cube as wide as the lattice, held by its middle alone: a twelfth of its volume lies in that tetrahedron at
  // most.
  const std::vector<Vec3> middle = {Vec3(0.013, 0.021, 0.034)};
  const HeldPoints alone = lattice_around(middle, 0.1, 0.1);
  EXPECT_GE(alone.outside[0], 1.0 - 1.0 / 12.0 - 0.05);
  EXPECT_LT(alone.outside[0], 1.0);
  EXPECT_EQ(lattice_around(middle, 0.1, 0.1, std::vector<std::uint8_t>{1}).outside[0], 0.0);
}

TEST(LatticeAround, NothingAndTooMuchAreRefused) {
  const std::vector<Vec3> none, two = {Vec3::Zero(), Vec3::Ones()};
  EXPECT_THROW(lattice_around(none, 0.1), InputError);
  EXPECT_THROW(lattice_around(two, 0.0), InputError);
  EXPECT_THROW(lattice_around(two, 1e-4, 0.0, {}, 1000), InputError);
}

}  // namespace
}  // namespace brim::lattice_around_test
