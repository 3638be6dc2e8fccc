#include "brim/raster/polyhedron_distances.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "brim/math/rotation.h"
#include "brim/mesh/distance.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/shape_builders.h"

namespace brim::polyhedron_distances_test {
namespace {

constexpr unsigned kSeed = 17;

/// Flat-faced solids, turned so that no face is along an axis.
std::vector<TriMesh> solids() {
  std::vector<TriMesh> out{
      shapes::box(Vec3(0.9, 0.5, 0.2), 2),
      shapes::icosphere(0.5, 0),
      shapes::cylinder(0.4, 0.7, 5),
      {{{0, 0, 0}, {0.9, 0, 0}, {0, 0.8, 0}, {0.1, 0.1, 0.6}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}}};
  // A roof of 1 degree, whose edge is left out.
  out.push_back(shapes::extrude_polygon({{-0.5, 0}, {0.5, 0}, {0.5, 0.4}, {0, 0.4044}, {-0.5, 0.4}}, 0.5));
  const Mat3 turn = rotation_from_vector(Vec3(0.4, -0.9, 0.3)).toRotationMatrix();
  for (TriMesh& mesh : out)
    for (Vec3& x : mesh.vertices) x = turn * x;
  return out;
}

struct Fixture {
  std::mt19937 rng{kSeed};
  std::uniform_real_distribution<double> u{-1.0, 1.0};
  Vec3 vector() {
    const double x = u(rng), y = u(rng);
    return {x, y, u(rng)};
  }
};

TEST(PolyhedronDistances, AreThoseToTheTriangles) {
  Fixture random;
  for (const TriMesh& mesh : solids()) {
    const PolyhedronDistances distance(*convex_polyhedron(mesh));
    const SurfaceTree tree(mesh);
    int inside = 0;
    for (int i = 0; i < 9000; ++i) {
      const Vec3 p = random.vector();
      const double exact = tree.signed_distance(p);
      inside += exact < 0.0;
      ASSERT_NEAR(distance(p), exact, 2e-4 * std::max(0.0, exact) * (mesh.vertices.size() == 10) + 1e-12);
    }
    EXPECT_GT(inside, 40);
  }
}

TEST(PolyhedronDistances, HaveTheirGradient) {
  Fixture random;
  constexpr double e = 1e-6;
  for (const TriMesh& mesh : solids()) {
    const PolyhedronDistances distance(*convex_polyhedron(mesh));
    int rough = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec3 p = random.vector();
      Vec3 g, differences;
      EXPECT_NEAR(distance(p, g), distance(p), 1e-14);
      EXPECT_NEAR(g.norm(), 1.0, 1e-12);
      for (int a = 0; a < 3; ++a)
        differences[a] = (distance(p + e * Vec3::Unit(a)) - distance(p - e * Vec3::Unit(a))) / (2.0 * e);
      rough += (g - differences).norm() > 1e-4;
    }
    EXPECT_LT(rough, 3);  // a kink between two faces, inside
  }
}

TEST(PolyhedronDistances, AreTheSameBitsAtManyPlaces) {
  Fixture random;
  constexpr int n = 203;
  std::vector<double> x(n), y(n), z(n), d(n);
  for (int i = 0; i < n; ++i) {
    const Vec3 p = random.vector();
    x[i] = p[0], y[i] = p[1], z[i] = p[2];
  }
  for (const TriMesh& mesh : solids()) {
    const PolyhedronDistances distance(*convex_polyhedron(mesh));
    distance.at({x.data(), y.data(), z.data(), n}, d.data());
    for (int i = 0; i < n; ++i) EXPECT_EQ(d[i], distance({x[i], y[i], z[i]}));
  }
}

TEST(PolyhedronDistances, OfACubeOfNodesAreThoseInSinglePrecision) {
  Fixture random;
  for (const TriMesh& mesh : solids()) {
    const PolyhedronDistances distance(*convex_polyhedron(mesh));
    for (int trial = 0; trial < 20; ++trial) {
      const Pose pose{rotation_from_vector(3.0 * random.vector()).toRotationMatrix(), random.vector()};
      const NodeCube cube{(10.0 * random.vector()).cast<int>(), 0.08};
      NodeMask wanted;
      for (auto& plane : wanted.plane) plane = random.rng() & random.rng();
      alignas(32) float d[kCubeNodes];
      distance.at(CubeFrame(pose, cube), wanted, d);
      wanted.for_rows([&](int j, int k, std::uint8_t row) {
        for (int i = 0; i < kCubeSize; ++i)
          if ((row >> i & 1) != 0) {
            EXPECT_NEAR(d[cube_index(i, j, k)], distance(pose.to_local(cube.origin() + cube.h * Vec3(i, j, k))), 2e-6);
          }
      });
    }
  }
}

}  // namespace
}  // namespace brim::polyhedron_distances_test
