#include "brim/mesh/distance.h"

#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/topology.h"
#include "mesh/data.h"

namespace brim::distance_test {
namespace {

TEST(Distance, FindsEachFeatureOfATriangle) {
  const Vec3 a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
  const auto at = [&](double x, double y) { return closest_on_triangle({x, y, 1.0}, a, b, c); };
  EXPECT_EQ(at(0.5, 0.5).feature, Feature::Face);
  EXPECT_EQ(at(-1, -1).feature, Feature::VertexA);
  EXPECT_EQ(at(4, 0).feature, Feature::VertexB);
  EXPECT_EQ(at(0, 4).feature, Feature::VertexC);
  EXPECT_EQ(at(1, -1).feature, Feature::EdgeAB);
  EXPECT_EQ(at(3, 3).feature, Feature::EdgeBC);
  EXPECT_EQ(at(-1, 1).feature, Feature::EdgeCA);
  EXPECT_NEAR((at(3, 3).point - Vec3(1, 1, 0)).norm(), 0.0, 1e-15);
}

TEST(Distance, ClosestPointIsNotBeatenByAnySampleOfTheTriangle) {
  const std::uint64_t seed = 3;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  const Aabb unit{Vec3::Constant(-1), Vec3::Constant(1)};
  for (int i = 0; i < 200; ++i) {
    const Vec3 a = random.in(unit), b = random.in(unit), p = 2.0 * random.in(unit);
    // Every fifth triangle is flat: its corners on one line.
    const Vec3 c = i % 5 == 0 ? Vec3(a + random(-1, 2) * (b - a)) : random.in(unit);
    const TrianglePoint q = closest_on_triangle(p, a, b, c);
    EXPECT_NEAR(q.barycentric.sum(), 1.0, 1e-12);
    EXPECT_GE(q.barycentric.minCoeff(), -1e-12);
    EXPECT_NEAR((q.point - (q.barycentric[0] * a + q.barycentric[1] * b + q.barycentric[2] * c)).norm(), 0.0, 1e-12);
    for (int k = 0; k < 100; ++k) {
      double u = random(0, 1), v = random(0, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      EXPECT_LE((q.point - p).norm(), (a + u * (b - a) + v * (c - a) - p).norm() + 1e-12);
    }
  }
}

TEST(Distance, TreeAgreesWithTryingEveryTriangle) {
  const std::uint64_t seed = 19;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  const TriMesh mesh = shapes::blob(4, 1.0, 3);
  const SurfaceTree tree(mesh);
  for (int i = 0; i < 300; ++i) {
    const Vec3 p = random.in(tree.box().inflated(0.5));
    const ClosestPoint fast = tree.closest(p), slow = closest_brute_force(mesh, p);
    EXPECT_EQ(fast.distance, slow.distance);
    EXPECT_EQ(tree.closest(p, fast.distance * 1.0001).triangle, fast.triangle);
    EXPECT_EQ(tree.closest(p, fast.distance * 0.999).triangle, -1);
    // Whatever triangle is known before.
    const auto near = static_cast<std::int32_t>(37 * static_cast<std::size_t>(i) % mesh.triangles.size());
    const ClosestPoint from = tree.closest_from(p, near);
    EXPECT_EQ(from.triangle, fast.triangle);
    EXPECT_EQ(from.distance, fast.distance);
  }
}

TEST(Distance, SignedDistanceOfASphereAndABox) {
  const std::uint64_t seed = 23;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  const SurfaceTree sphere(shapes::icosphere(1.0, 5)), box(shapes::box({2, 1, 0.5}));
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = random.in({Vec3::Constant(-2), Vec3::Constant(2)});
    EXPECT_NEAR(sphere.signed_distance(p), p.norm() - 1.0, 1e-3);  // the sagitta of an edge of length 0.04 is 3e-4
    const Vec3 q = p.cwiseAbs() - Vec3(1, 0.5, 0.25);
    const double exact = q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
    EXPECT_NEAR(box.signed_distance(p), exact, 1e-12);
  }
}

TEST(Distance, PseudonormalAndWindingNumberAgreeOnClosedSurfaces) {
  const std::uint64_t seed = 29;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  for (const TriMesh& mesh : {shapes::gear(9, 1, 0.7, 0.3, 0.2), shapes::blob(8, 0.6, 4), shapes::cup(0.5, 1, 0.05)}) {
    const SurfaceTree tree(mesh);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 p = random.in(tree.box().inflated(0.1));
      const double w = tree.winding_number_exact(p);
      EXPECT_NEAR(w, std::round(w), 1e-9);
      EXPECT_EQ(tree.signed_distance(p) < 0.0, w > 0.5) << p.transpose();
    }
  }
}

TEST(Distance, FastWindingNumberIsNearTheExactOne) {
  const std::uint64_t seed = 31;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  TriMesh mesh = shapes::blob(2, 1.0, 4);
  mesh.triangles.resize(mesh.triangles.size() * 3 / 4);  // with a large hole
  const SurfaceTree tree(mesh);
  double worst = 0.0, worst_careful = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = random.in(tree.box().inflated(0.5));
    const double exact = tree.winding_number_exact(p);
    worst = std::max(worst, std::abs(tree.winding_number(p) - exact));
    worst_careful = std::max(worst_careful, std::abs(tree.winding_number(p, 8.0) - exact));
  }
  EXPECT_LT(worst, 0.03);  // enough to tell 1/2 from 0 and 1
  EXPECT_LT(worst_careful, 0.2 * worst);
  EXPECT_NEAR(tree.winding_number({0.1, 0.2, 0.0}, 1e9), tree.winding_number_exact({0.1, 0.2, 0.0}), 1e-13);
}

TEST(Distance, RefusesSurfacesWithoutTrianglesOrWithNotANumber) {
  EXPECT_THROW(SurfaceTree(TriMesh{}), InputError);
  TriMesh mesh = shapes::box({1, 1, 1});
  mesh.vertices[3].y() = std::nan("");
  EXPECT_THROW(SurfaceTree{mesh}, InputError);
  mesh = shapes::box({1, 1, 1});
  mesh.triangles[0][1] = 77;
  EXPECT_THROW(SurfaceTree{mesh}, InputError);
}

}  // namespace
}  // namespace brim::distance_test
