#include "brim/mesh/primitives.h"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>

#include "brim/core/error.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/topology.h"

namespace brim::primitives_test {
namespace {

using std::numbers::pi;

double longest_edge(const TriMesh& mesh) {
  double l = 0.0;
  for (const Edge& e : edges(mesh.triangles)) l = std::max(l, (mesh.vertices[e[0]] - mesh.vertices[e[1]]).norm());
  return l;
}

struct Shape {
  const char* name;
  TriMesh mesh;
  double volume;     // [m³], 0: not known
  double tolerance;  // relative
  int genus;
};

std::vector<Shape> all_shapes() {
  const double g = 0.2;  // thickness of the flat ones
  return {{"box", shapes::box({1, 2, 3}, 4), 6.0, 1e-12, 0},
          {"icosphere", shapes::icosphere(1, 4), 4.0 / 3.0 * pi, 5e-3, 0},
          {"capsule", shapes::capsule(0.5, 2.0), pi * 0.25 * 2.0 + 4.0 / 3.0 * pi * 0.125, 6e-3, 0},
          {"cylinder", shapes::cylinder(0.5, 2.0, 128), pi * 0.25 * 2.0, 1e-3, 0},
          {"fine cylinder", shapes::cylinder(0.5, 2.0, 128, 0.1), pi * 0.25 * 2.0, 1e-3, 0},
          {"torus", shapes::torus(1, 0.25), 2 * pi * pi * 0.0625, 5e-3, 1},
          {"gear", shapes::gear(12, 1.0, 0.8, g, 0.3), 0.0, 0.0, 1},
          {"solid gear", shapes::gear(9, 1.0, 0.8, g, 0.0), 0.0, 0.0, 0},
          {"fine gear", shapes::gear(12, 1.0, 0.8, g, 0.3, 0.08), 0.0, 0.0, 1},
          // Area of a star: 2 n triangles (centre, tip, notch).
          {"star", shapes::star(5, 1.0, 0.4, g), 10 * 0.5 * 0.4 * std::sin(pi / 5) * g, 1e-12, 0},
          {"fine star", shapes::star(5, 1.0, 0.4, g, 0.05), 10 * 0.5 * 0.4 * std::sin(pi / 5) * g, 1e-12, 0},
          {"blob", shapes::blob(3, 1.0, 4), 0.0, 0.0, 0},
          {"bowl", shapes::bowl(1.0, 0.1, 128), 2.0 / 3.0 * pi * (1 - 0.729) + pi * pi * 0.0025 * 0.95, 1e-2, 0},
          {"cup", shapes::cup(0.5, 1.0, 0.1, 128), pi * (0.25 - 0.16 * 0.9), 1e-3, 0},
          {"L", shapes::l_profile(1.0, 0.8, 0.2, 2.0, 0.1), (0.2 + 0.6 * 0.2) * 2.0, 1e-12, 0},
          {"U", shapes::u_profile(1.0, 0.5, 0.1, 2.0, 0.1), (0.1 + 2 * 0.4 * 0.1) * 2.0, 1e-12, 0}};
}

TEST(Primitives, AreClosedOrientedManifoldAndOutward) {
  for (const Shape& s : all_shapes()) {
    const MeshReport r = inspect(s.mesh);
    SCOPED_TRACE(std::string(s.name) + ": " + r.summary());
    EXPECT_TRUE(r.closed() && r.oriented() && r.manifold());
    EXPECT_EQ(r.pieces, 1u);
    EXPECT_EQ(r.degenerate_triangles + r.duplicate_vertices + r.unused_vertices, 0u);
    EXPECT_GT(r.volume, 0.0);
    // Euler's formula: V − E + F = 2 − 2 genus.
    EXPECT_EQ(static_cast<long>(r.vertices) - static_cast<long>(r.edges) + static_cast<long>(r.triangles),
              2 - 2 * s.genus);
    if (s.volume > 0.0) {
      EXPECT_NEAR(r.volume / s.volume, 1.0, s.tolerance);
    }
  }
}

TEST(Primitives, RefinementKeepsTheSolidAndBoundsTheEdges) {
  const TriMesh coarse = shapes::gear(12, 1.0, 0.8, 0.2, 0.3), fine = shapes::gear(12, 1.0, 0.8, 0.2, 0.3, 0.05);
  EXPECT_GT(longest_edge(coarse), 0.2);
  EXPECT_LE(longest_edge(fine), 0.05 * (1 + 1e-9));
  EXPECT_NEAR(enclosed_volume(fine) / enclosed_volume(coarse), 1.0, 1e-12);
  EXPECT_NEAR(surface_area(fine) / surface_area(coarse), 1.0, 1e-12);
}

TEST(Primitives, BlobDependsOnItsSeedOnly) {
  const TriMesh a = shapes::blob(1, 0.5, 3), b = shapes::blob(1, 0.5, 3), c = shapes::blob(2, 0.5, 3);
  double same = 0.0, other = 0.0;
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    same += (a.vertices[i] - b.vertices[i]).norm();
    other = std::max(other, (a.vertices[i] - c.vertices[i]).norm());
  }
  EXPECT_EQ(same, 0.0);
  EXPECT_GT(other, 0.05);
}

TEST(Primitives, BlobIsNotConvex) {
  // A convex body lies behind every one of its face planes.
  const TriMesh m = shapes::blob(1, 1.0, 3);
  double farthest = 0.0;
  for (const Triangle& t : m.triangles) {
    const Vec3 n = (m.vertices[t[1]] - m.vertices[t[0]]).cross(m.vertices[t[2]] - m.vertices[t[0]]).normalized();
    for (const Vec3& x : m.vertices) farthest = std::max(farthest, n.dot(x - m.vertices[t[0]]));
  }
  EXPECT_GT(farthest, 0.1);
}

TEST(Primitives, GridIsAnOpenSheetFacingUp) {
  const TriMesh m = shapes::grid(5, 3, 2.0, 1.0);
  const MeshReport r = inspect(m);
  EXPECT_EQ(r.vertices, 24u);
  EXPECT_EQ(r.triangles, 30u);
  EXPECT_EQ(r.boundary_edges, 16u);
  EXPECT_TRUE(r.manifold() && r.oriented());
  EXPECT_NEAR(surface_area(m), 2.0, 1e-14);
  for (const Vec3& n : vertex_normals(m.vertices, m.triangles)) EXPECT_NEAR((n - Vec3::UnitZ()).norm(), 0.0, 1e-14);
}

TEST(Primitives, RefuseSizesWithoutMeaning) {
  EXPECT_THROW(shapes::box({1, 0, 1}), InputError);
  EXPECT_THROW(shapes::icosphere(-1), InputError);
  EXPECT_THROW(shapes::torus(1, 2), InputError);
  EXPECT_THROW(shapes::gear(2, 1, 0.8, 0.1, 0), InputError);
  EXPECT_THROW(shapes::gear(8, 1, 0.8, 0.1, 0.9), InputError);
  EXPECT_THROW(shapes::star(5, 1, 0.5, 0.1, -0.1), InputError);
  EXPECT_THROW(shapes::grid(0, 1, 1, 1), InputError);
  EXPECT_THROW(shapes::cup(1, 1, std::nan("")), InputError);
}

}  // namespace
}  // namespace brim::primitives_test
