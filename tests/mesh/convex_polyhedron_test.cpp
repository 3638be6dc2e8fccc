#include "brim/mesh/convex_polyhedron.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/shape_builders.h"
#include "brim/mesh/topology.h"

namespace brim::convex_polyhedron_test {
namespace {

TEST(ConvexPolyhedron, OfABlockHasItsSixFacesHoweverItIsTriangulated) {
  for (const int subdivisions : {1, 2, 7}) {
    const auto found = convex_polyhedron(shapes::box(Vec3(0.3, 0.5, 0.7), subdivisions));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->faces.size(), 6u);
    EXPECT_EQ(found->corners.size(), 8u);
    ASSERT_EQ(found->edges.size(), 12u);
    double length = 0.0;
    for (const auto& e : found->edges) {
      length += e.length;
      EXPECT_NEAR(e.cosine, 0.0, 1e-12);
      const Vec3 way = found->corners[static_cast<std::size_t>(e.corners[1])] -
                       found->corners[static_cast<std::size_t>(e.corners[0])];
      EXPECT_LT((way - e.length * e.along).norm(), 1e-12);
      for (const int f : e.faces)
        for (const int c : e.corners) {
          const auto& face = found->faces[static_cast<std::size_t>(f)];
          EXPECT_NEAR(face.normal.dot(found->corners[static_cast<std::size_t>(c)]), face.offset, 1e-12);
        }
    }
    EXPECT_NEAR(length, 4.0 * 1.5, 1e-12);
  }
}

TEST(ConvexPolyhedron, OfSolidsWithOtherFacesObeysEuler) {
  TriMesh corner{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  EXPECT_EQ(convex_polyhedron(corner)->faces.size(), 4u);
  EXPECT_EQ(convex_polyhedron(shapes::icosphere(1.0, 0))->faces.size(), 20u);
  EXPECT_EQ(convex_polyhedron(shapes::cylinder(1.0, 2.0, 6))->faces.size(), 8u);
  // One blunt edge of fifteen: a roof of six degrees.
  EXPECT_EQ(
      convex_polyhedron(shapes::extrude_polygon({{-1, 0}, {1, 0}, {1, 1}, {0, 1.05}, {-1, 1}}, 0.5))->faces.size(), 7u);
  // A square with a corner in the middle of each side.
  EXPECT_EQ(convex_polyhedron(shapes::star(4, std::sqrt(0.5), 0.5, 1.0))->edges.size(), 12u);
}

TEST(ConvexPolyhedron, BearsTheRoundingOfFilesInSinglePrecision) {
  TriMesh mesh = shapes::box(Vec3(0.3, 0.5, 0.7), 6);
  for (Vec3& x : mesh.vertices) x = (x + Vec3(2.1, 0.3, 0.7)).cast<float>().cast<double>();
  ASSERT_TRUE(convex_polyhedron(mesh));
  EXPECT_EQ(convex_polyhedron(mesh)->faces.size(), 6u);
}

TEST(ConvexPolyhedron, IsNotFoundInOtherSurfaces) {
  EXPECT_FALSE(convex_polyhedron(shapes::l_profile(1.0, 1.0, 0.3, 0.5)));  // not convex
  EXPECT_FALSE(convex_polyhedron(shapes::icosphere(1.0, 2)));              // many faces
  EXPECT_FALSE(convex_polyhedron(shapes::cylinder(1.0, 2.0, 32)));         // nearly round
  EXPECT_FALSE(convex_polyhedron(shapes::grid(2, 2, 1.0, 1.0)));           // open
  EXPECT_FALSE(convex_polyhedron({}));
  TriMesh two = shapes::box(Vec3::Ones());
  const auto shift = static_cast<std::int32_t>(two.vertices.size());
  for (std::int32_t v = 0; v < shift; ++v) two.vertices.push_back(two.vertices[static_cast<std::size_t>(v)]);
  for (std::size_t t = 0, n = two.triangles.size(); t < n; ++t) {
    Triangle copy = two.triangles[t];
    for (auto& v : copy) v += shift;
    two.triangles.push_back(copy);
  }
  EXPECT_FALSE(convex_polyhedron(two));  // two pieces in one place
  TriMesh inward = shapes::box(Vec3::Ones());
  for (Triangle& t : inward.triangles) std::swap(t[0], t[1]);
  EXPECT_FALSE(convex_polyhedron(inward));
  TriMesh dented = shapes::box(Vec3::Ones(), 2);
  for (Vec3& x : dented.vertices)
    if (x.head<2>().norm() == 0.0 && x.z() > 0.0) x.z() -= 1e-3;
  EXPECT_FALSE(convex_polyhedron(dented));
}

}  // namespace
}  // namespace brim::convex_polyhedron_test
