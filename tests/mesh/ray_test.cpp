#include "brim/mesh/ray.h"

#include <gtest/gtest.h>

#include <cmath>

#include "brim/mesh/primitives.h"
#include "mesh/data.h"

namespace brim::ray_test {
namespace {

const Aabb kUnit{Vec3::Constant(-1), Vec3::Constant(1)};

TEST(Ray, MeetsBallCapsuleAndSlabWhereTheyAreByHand) {
  const Ray down{Vec3(0.25, 0.25, 3), -Vec3::UnitZ()};
  RoundedSimplex s;
  s.corner = {Vec3(0.25, 0.25, 0), Vec3(2, 0.25, 0), Vec3(0, 2, 0)};
  for (s.corners = 1; s.corners <= 3; ++s.corners) {
    s.radius = 0.5;
    const auto entry = enter(down, s);
    ASSERT_TRUE(entry) << s.corners;
    EXPECT_DOUBLE_EQ(entry->distance, 2.5);
    EXPECT_NEAR((entry->normal - Vec3::UnitZ()).norm(), 0.0, 1e-15);
  }
  s.corners = 3, s.radius = 0.0;
  EXPECT_DOUBLE_EQ(enter(down, s)->distance, 3.0);
  Ray close = down;
  close.length = 2.9;
  EXPECT_FALSE(enter(close, s));
  EXPECT_FALSE(enter(Ray{Vec3(0.25, 0.25, 3), Vec3::UnitZ()}, s)) << "it is behind";
}

TEST(Ray, TheEntryLiesOnTheSurfaceAndNothingOfTheMatterLiesBefore) {
  const std::uint64_t seed = 11;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  int met = 0;
  for (int i = 0; i < 4000; ++i) {
    RoundedSimplex s;
    s.corners = 1 + i % 3;
    s.corner = {random.in(kUnit), random.in(kUnit), random.in(kUnit)};
    s.radius = random(0.05, 0.4);
    const Vec3 from = 3.0 * random.in(kUnit);
    const Ray ray{from, (0.7 * random.in(kUnit)-from).normalized(), 8.0};
    if (nearest(ray.origin, s).distance <= 0.0) continue;
    const auto entry = enter(ray, s);
    const double end = entry ? entry->distance : ray.length;
    for (int k = 0; k < 200; ++k) ASSERT_GT(nearest(ray.at(random(0, 1) * end), s).distance, -1e-9) << i;
    if (!entry) continue;
    ++met;
    const NearPoint near = nearest(ray.at(end), s);
    EXPECT_NEAR(near.distance, 0.0, 1e-9);
    EXPECT_NEAR((near.normal - entry->normal).norm(), 0.0, 1e-6) << i;
    EXPECT_LE(entry->normal.dot(ray.direction), 1e-12);
  }
  EXPECT_GT(met, 300);
}

TEST(Ray, NoneSlipsBetweenTrianglesWithACommonEdge) {
  const std::uint64_t seed = 12;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  const TriMesh mesh = shapes::icosphere(1.0, 2);
  const auto meets = [&](const Ray& ray) {
    for (const Triangle& t : mesh.triangles)
      if (enter(ray, {{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, 3, 0.0})) return true;
    return false;
  };
  for (const Vec3& x : mesh.vertices) EXPECT_TRUE(meets({Vec3::Zero(), x.normalized()}));
  for (int i = 0; i < 500; ++i) {
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(i) % mesh.triangles.size()];
    const double s = random(0, 1);
    const Vec3 on_edge = (1.0 - s) * mesh.vertices[t[0]] + s * mesh.vertices[t[1]];
    const Vec3 from = 0.3 * random.in(kUnit);
    EXPECT_TRUE(meets({from, (on_edge - from).normalized()})) << i;
  }
}

TEST(Ray, ADegenerateSimplexIsTheSmallerOne) {
  const Vec3 a(0, 0, 0), b(1, 0, 0);
  const Ray ray{Vec3(0.5, 0, 2), -Vec3::UnitZ()};
  EXPECT_NEAR(enter(ray, {{a, b, a}, 3, 0.1})->distance, 1.9, 1e-12) << "two corners of a triangle are one";
  EXPECT_NEAR(enter({Vec3(0, 0, 2), -Vec3::UnitZ()}, {{a, a, a}, 2, 0.1})->distance, 1.9, 1e-12);
  EXPECT_FALSE(enter(ray, {{a, b, a}, 3, 0.0}));
  EXPECT_NEAR(nearest(Vec3(0.5, 0, 0), {{a, b, a}, 2, 0.1}).distance, -0.1, 1e-15) << "on the axis";
}

TEST(Ray, ClipGivesTheRangeInABox) {
  double begin = 0.0, end = 0.0;
  EXPECT_TRUE(clip({Vec3(-3, 0, 0), Vec3::UnitX()}, kUnit, begin, end));
  EXPECT_DOUBLE_EQ(begin, 2.0);
  EXPECT_DOUBLE_EQ(end, 4.0);
  EXPECT_FALSE(clip({Vec3(-3, 2, 0), Vec3::UnitX()}, kUnit, begin, end)) << "beside it";
  EXPECT_FALSE(clip({Vec3(3, 0, 0), Vec3::UnitX()}, kUnit, begin, end)) << "behind";
  EXPECT_FALSE(clip({Vec3(-3, 0, 0), Vec3::UnitX(), 1.5}, kUnit, begin, end)) << "too far";
}

}  // namespace
}  // namespace brim::ray_test
