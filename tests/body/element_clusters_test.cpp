#include "brim/body/particles/element_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

#include "support/solids.h"

namespace brim::testing::element_clusters_test {
namespace {

constexpr unsigned kSeed = 5;

/// A crushed block whose nodes move anyhow.
struct Crushed {
  TetMesh mesh = block(6, 5, 4, 0.1);
  std::vector<Vec3> x = mesh.vertices;
  std::vector<double> v = std::vector<double>(3 * x.size());
  ElementClusters clusters;

  Crushed() {
    std::normal_distribution<double> normal;
    for (Vec3& p : x) p += 0.2 * Vec3(normal(rng), normal(rng), normal(rng));  // beyond recognition
    for (double& c : v) c = normal(rng);
    clusters.build(mesh.vertices, {{mesh.tets.front().data(), 4 * mesh.tets.size()}, 4});
  }
  /// A point of tetrahedron t and its velocity.
  std::pair<Vec3, Vec3> any_point(const Tetrahedron& t) {
    std::exponential_distribution<double> positive;
    Eigen::Vector4d w(positive(rng), positive(rng), positive(rng), positive(rng));
    w /= w.sum();
    Vec3 p = Vec3::Zero(), u = Vec3::Zero();
    for (int i = 0; i < 4; ++i) p += w[i] * x[t[i]], u += w[i] * Vec3(v[3 * t[i]], v[3 * t[i] + 1], v[3 * t[i] + 2]);
    return {p, u};
  }

 private:
  std::mt19937 rng{kSeed};
};

bool inside(const Aabb& box, const Vec3& p) {
  return ((p - box.lo).array() >= -1e-12).all() && ((box.hi - p).array() >= -1e-12).all();
}

bool held(const std::vector<MotionCluster>& clusters, const std::pair<Vec3, Vec3>& point) {
  return std::any_of(clusters.begin(), clusters.end(), [&](const MotionCluster& c) {
    return inside(c.box, point.first) && inside(c.velocity, point.second);
  });
}

TEST(ElementClusters, EveryPointOfEveryElementIsHeldWithItsVelocity) {
  SCOPED_TRACE(kSeed);
  Crushed body;
  EXPECT_GT(body.clusters.size(), 4u);
  std::vector<MotionCluster> coarse, fine;
  body.clusters.measure(body.x, body.v, 0.0, coarse);
  ASSERT_EQ(coarse.size(), body.clusters.size());
  for (std::size_t c = 0; c < coarse.size(); ++c) body.clusters.measure_finer(c, body.x, body.v, 0.0, fine);
  EXPECT_GT(fine.size(), 4 * coarse.size());
  for (const Tetrahedron& t : body.mesh.tets) {
    const auto point = body.any_point(t);
    EXPECT_TRUE(held(coarse, point));
    EXPECT_TRUE(held(fine, point));
  }
}

TEST(ElementClusters, FinerOnesLieWithinTheirs) {
  SCOPED_TRACE(kSeed);
  const Crushed body;
  std::vector<MotionCluster> coarse;
  body.clusters.measure(body.x, body.v, 0.03, coarse);
  for (std::size_t c = 0; c < coarse.size(); ++c) {
    std::vector<MotionCluster> finer;
    body.clusters.measure_finer(c, body.x, body.v, 0.03, finer);
    EXPECT_GE(finer.size(), 2u);
    for (const MotionCluster& f : finer)
      EXPECT_TRUE(inside(coarse[c].box, f.box.lo) && inside(coarse[c].box, f.box.hi) &&
                  inside(coarse[c].velocity, f.velocity.lo) && inside(coarse[c].velocity, f.velocity.hi));
  }
}

TEST(ElementClusters, ParticlesWithoutElementsAreElements) {
  const std::vector<Vec3> x = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0), Vec3(4, 0, 0)};
  const std::vector<double> v(15, 0.0);
  ElementClusters clusters;
  clusters.build(x, {});
  ASSERT_EQ(clusters.size(), 1u);
  std::vector<MotionCluster> finer;
  clusters.measure_finer(0, x, v, 0.5, finer);
  ASSERT_EQ(finer.size(), 2u);
  EXPECT_DOUBLE_EQ(finer[0].box.lo.x(), -0.5);
  EXPECT_DOUBLE_EQ(finer[1].box.hi.x(), 4.5);
}

}  // namespace
}  // namespace brim::testing::element_clusters_test
