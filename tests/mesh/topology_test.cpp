#include "brim/mesh/topology.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "brim/core/error.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "mesh/data.h"

namespace brim::topology_test {
namespace {

TEST(Topology, CountsWhatIsWrongWithAMessyMesh) {
  // Two triangles on one edge in the same direction, a sliver, an unused and a duplicate vertex.
  TriMesh m;
  m.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 0, 0}, {0, 0, 0}, {5, 5, 5}};
  m.triangles = {{0, 1, 2}, {1, 2, 3}, {0, 1, 4}};
  const MeshReport r = inspect(m);
  EXPECT_EQ(r.edges, 7u);
  EXPECT_EQ(r.boundary_edges, 5u);
  EXPECT_EQ(r.misoriented_edges, 2u);
  EXPECT_EQ(r.degenerate_triangles, 1u);
  EXPECT_EQ(r.duplicate_vertices, 1u);
  EXPECT_EQ(r.unused_vertices, 2u);
  EXPECT_EQ(r.pieces, 1u);
  EXPECT_FALSE(r.closed() || r.oriented());
  EXPECT_TRUE(r.manifold());
  EXPECT_NE(r.summary().find("open (5 boundary edges)"), std::string::npos) << r.summary();
}

TEST(Topology, SeesEdgesOfThreeTrianglesAndVerticesOfTwoFans) {
  TriMesh book;
  book.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
  book.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  EXPECT_EQ(inspect(book).nonmanifold_edges, 1u);
  EXPECT_THROW(interior_edges(book.triangles), InputError);

  TriMesh bow_tie;
  bow_tie.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  bow_tie.triangles = {{0, 1, 2}, {0, 3, 4}};
  EXPECT_EQ(inspect(bow_tie).nonmanifold_vertices, 1u);
  EXPECT_EQ(inspect(bow_tie).pieces, 1u);
}

TEST(Topology, ASurfaceThatIsThereTwiceIsNotClosed) {
  TriMesh box = shapes::box(Vec3(1, 1, 1));
  ASSERT_TRUE(inspect(box).closed());
  const std::vector<Triangle> once = box.triangles;
  for (Triangle t : once) {
    std::rotate(t.begin(), t.begin() + 1, t.end());
    box.triangles.push_back(t);
  }
  const MeshReport r = inspect(box);
  EXPECT_EQ(r.boundary_edges, 0u);
  EXPECT_EQ(r.repeated_triangles, once.size());
  EXPECT_FALSE(r.closed()) << "it would weigh twice as much";
  EXPECT_NE(r.summary().find("12 repeated triangles"), std::string::npos) << r.summary();
}

TEST(Topology, EmptyMeshIsNotClosed) {
  const MeshReport r = inspect(TriMesh{});
  EXPECT_FALSE(r.closed());
  EXPECT_EQ(r.pieces, 0u);
}

TEST(Topology, RefusesTrianglesOfMissingVertices) {
  TriMesh m;
  m.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  m.triangles = {{0, 1, 3}};
  EXPECT_THROW(inspect(m), InputError);
}

TEST(Topology, HingesOfTwoTrianglesNameTheOppositeVertices) {
  const std::vector<Triangle> t = {{0, 1, 2}, {2, 1, 3}};
  const std::vector<Hinge> h = interior_edges(t);
  ASSERT_EQ(h.size(), 1u);
  EXPECT_EQ(std::tie(h[0].a, h[0].b, h[0].c, h[0].d), std::make_tuple(1, 2, 0, 3));
  EXPECT_EQ(std::tie(h[0].left, h[0].right), std::make_tuple(0, 1));
  EXPECT_THROW(interior_edges(std::vector<Triangle>{{0, 1, 2}, {1, 2, 3}}), InputError);
}

TEST(Topology, InteriorAndBoundaryEdgesAddUpToAllEdges) {
  const TriMesh m = shapes::grid(7, 4, 1, 1);
  EXPECT_EQ(interior_edges(m.triangles).size() + boundary_edges(m.triangles).size(), edges(m.triangles).size());
  for (const Hinge& h : interior_edges(m.triangles)) {
    const auto cyclic = [&](std::int32_t t, Triangle want) {
      for (int k = 0; k < 3; ++k) {
        if (m.triangles[t] == want) return true;
        std::rotate(want.begin(), want.begin() + 1, want.end());
      }
      return false;
    };
    EXPECT_TRUE(cyclic(h.left, {h.a, h.b, h.c}));
    EXPECT_TRUE(cyclic(h.right, {h.b, h.a, h.d}));
  }
}

TEST(Topology, WeldingASoupGivesTheMeshBack) {
  const std::uint64_t seed = 11;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  const TriMesh m = shapes::icosphere(1.0, 3);
  TriMesh soup;
  for (const Triangle& t : m.triangles) {
    const auto n = static_cast<std::int32_t>(soup.vertices.size());
    for (const std::int32_t v : t) {
      const Vec3 noise(random(-1, 1), random(-1, 1), random(-1, 1));
      soup.vertices.push_back(m.vertices[v] + 1e-7 * noise);
    }
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  EXPECT_EQ(inspect(soup).pieces, m.triangles.size());
  EXPECT_FALSE(inspect(weld(soup, 0.0)).closed());
  const MeshReport r = inspect(weld(soup, 1e-6));
  EXPECT_EQ(r.vertices, m.vertices.size());
  EXPECT_TRUE(r.closed() && r.oriented() && r.manifold()) << r.summary();
  EXPECT_THROW(weld(soup, -1.0), InputError);
}

TEST(Topology, SurfaceOfTetrahedraIsClosedOutwardAndOwned) {
  // A box of 2 x 1 x 1 cells of six tetrahedra each around the cell's diagonal.
  TetMesh m;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 3; ++i) m.vertices.emplace_back(i, j, k);
  for (int i = 0; i < 2; ++i) {
    std::array<int, 3> axes = {0, 1, 2};
    do {
      const std::array<int, 3> step = {1, 3, 6};
      Tetrahedron t = {i, i + step[axes[0]], i + step[axes[0]] + step[axes[1]], i + 10};
      if (tet_volume(m.vertices[t[0]], m.vertices[t[1]], m.vertices[t[2]], m.vertices[t[3]]) < 0) std::swap(t[0], t[1]);
      m.tets.push_back(t);
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  const TetSurface s = tet_surface(m);
  EXPECT_EQ(s.triangles.size(), 20u);
  const MeshReport r = inspect(TriMesh{m.vertices, s.triangles});
  EXPECT_TRUE(r.closed() && r.oriented() && r.manifold()) << r.summary();
  EXPECT_NEAR(r.volume, 2.0, 1e-14);
  ASSERT_EQ(s.owner.size(), s.triangles.size());
  for (std::size_t i = 0; i < s.owner.size(); ++i)
    for (const std::int32_t v : s.triangles[i]) {
      const Tetrahedron& t = m.tets[s.owner[i]];
      EXPECT_NE(std::find(t.begin(), t.end(), v), t.end());
    }
  EXPECT_EQ(edges(m.tets).size(), 20u + 11u + 2u);  // lattice edges, face diagonals, cell diagonals
}

TEST(Topology, VertexNormalsOfASphereAreRadial) {
  const TriMesh m = shapes::icosphere(2.0, 4);
  const std::vector<Vec3> n = vertex_normals(m.vertices, m.triangles);
  for (std::size_t i = 0; i < n.size(); ++i) EXPECT_GT(n[i].dot(m.vertices[i]) / 2.0, 0.9999);
}

TEST(Topology, RealMeshesAreWhatTheyAreSaidToBe) {
  struct Expected {
    const char* name;
    bool closed;
  };
  int found = 0;
  for (const Expected& e :
       {Expected{"spot.obj", true}, Expected{"fandisk.obj", true}, Expected{"rocker-arm.obj", true},
        Expected{"stanford-bunny.obj", false}, Expected{"teapot.obj", false}, Expected{"suzanne.obj", false}}) {
    const auto path = test::data_file(e.name);
    if (path.empty()) continue;
    ++found;
    const MeshReport r = inspect(weld(test::read_plain_obj(path), 0.0));
    EXPECT_EQ(r.closed(), e.closed) << e.name << ": " << r.summary();
    if (e.closed) {
      EXPECT_TRUE(r.oriented() && r.manifold() && r.volume > 0.0) << e.name << ": " << r.summary();
    }
  }
  if (found == 0) GTEST_SKIP() << "no test data";
}

}  // namespace
}  // namespace brim::topology_test
