#include "brim/raster/splat_reach.h"

#include <gtest/gtest.h>

#include "support/solids.h"

namespace brim::splat_reach_test {
namespace {

constexpr unsigned kSeed = 23;

struct Surface {
  std::vector<Vec3> x;
  std::vector<Triangle> triangles;

  double distance(const Vec3& r, std::size_t t) const {
    const Triangle& c = triangles[t];
    return testing::triangle_distance(r, x[c[0]], x[c[1]], x[c[2]]);
  }
  Aabb box(std::size_t t, const Vec3& by) const {
    Aabb b;
    for (const std::int32_t i : triangles[t]) b.extend(x[i]);
    return {b.lo - by, b.hi + by};
  }
};

/// A wavy, open sheet. @param waves  height of the waves  @param shake  of each vertex
Surface sheet(double waves, double shake, unsigned seed) {
  constexpr int kSide = 9;
  testing::Noise noise(seed);
  Surface s;
  for (int j = 0; j <= kSide; ++j)
    for (int i = 0; i <= kSide; ++i)
      s.x.push_back(Vec3(0.1 * i, 0.1 * j, waves * std::sin(0.9 * i) * std::cos(0.7 * j)) + shake * noise.vec());
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const auto at = [&](int a, int b) { return i + a + (kSide + 1) * (j + b); };
      s.triangles.push_back({at(0, 0), at(1, 0), at(0, 1)});
      s.triangles.push_back({at(1, 0), at(1, 1), at(0, 1)});
    }
  return s;
}

/// Checks that random nodes lie in the reach of a triangle that is as near as any.
void expect_nearest_in_reach(const Surface& s, double reach, unsigned seed) {
  testing::Noise noise(seed);
  SplatReach splat;
  splat.build(s.x, s.triangles, reach);
  Aabb all;
  for (const Vec3& v : s.x) all.extend(v);
  all = all.inflated(reach);
  int near = 0;
  for (int round = 0; round < 1000; ++round) {
    const Vec3 r = all.center() + 0.5 * all.extent().cwiseProduct(noise.vec());
    double nearest = 1e9, reached = 1e9;
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
      const double d = s.distance(r, t);
      nearest = std::min(nearest, d);
      const Aabb box = s.box(t, splat.beyond(t));
      if ((r.array() >= box.lo.array()).all() && (r.array() <= box.hi.array()).all()) reached = std::min(reached, d);
    }
    if (!(nearest < reach)) continue;
    ++near;
    ASSERT_NEAR(reached, nearest, 1e-9) << "at " << r.transpose();
  }
  EXPECT_GT(near, 100);
}

TEST(SplatReach, HoldsEveryNodeThatIsNearestToATriangle) {
  for (const double waves : {0.0, 0.02, 0.1, 0.4})
    for (const double shake : {0.0, 0.005, 0.03})
      for (unsigned seed = kSeed; seed < kSeed + 2; ++seed) {
        SCOPED_TRACE(::testing::Message() << waves << " " << shake << " " << seed);
        expect_nearest_in_reach(sheet(waves, shake, seed), 0.15, seed);
      }
}

TEST(SplatReach, HoldsEveryNodeOfClosedSolids) {
  for (const double shake : {0.0, 0.03, 0.1}) {
    SCOPED_TRACE(shake);
    testing::Noise noise(kSeed);
    TetMesh mesh = testing::block(4, 4, 4, 0.3);
    for (Vec3& x : mesh.vertices) x += shake * noise.vec();
    expect_nearest_in_reach({mesh.vertices, testing::boundary(mesh).triangles}, 0.25, kSeed);
  }
}

TEST(SplatReach, TrianglesTurnedOverOrWithoutAreaTakeNothingAway) {
  Surface s = sheet(0.02, 0.0, kSeed);
  std::swap(s.triangles[40][0], s.triangles[40][1]);
  s.x[55] = s.x[56];
  expect_nearest_in_reach(s, 0.15, kSeed);
}

TEST(SplatReach, IsStraightAboveAndBelowWhereASurfaceIsFlat) {
  const Surface s = sheet(0.0, 0.0, kSeed);
  SplatReach splat;
  splat.build(s.x, s.triangles, 0.15);
  const Vec3 middle = splat.beyond(2 * (4 + 9 * 4)), corner = splat.beyond(0);
  EXPECT_NEAR(middle.z(), 0.15, 1e-6);
  EXPECT_LT(middle.x(), 0.002);
  EXPECT_LT(middle.y(), 0.002);
  EXPECT_NEAR(corner.x(), 0.15, 1e-6);
}

}  // namespace
}  // namespace brim::splat_reach_test
