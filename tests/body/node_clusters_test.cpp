#include "brim/body/particles/node_clusters.h"

#include <gtest/gtest.h>

#include <random>

#include "support/solids.h"

namespace brim::testing {
namespace {

constexpr unsigned kSeed = 5;

TEST(NodeClusters, EveryPointOfEveryElementIsHeldWithItsVelocity) {
  SCOPED_TRACE(kSeed);
  const TetMesh mesh = block(6, 5, 4, 0.1);
  BlockMatrix pattern;
  std::vector<std::int32_t> corners;
  for (const Tetrahedron& t : mesh.tets) corners.insert(corners.end(), t.begin(), t.end());
  pattern.begin(mesh.vertices.size());
  pattern.add_elements(corners, 4);
  pattern.finish();
  NodeClusters clusters;
  clusters.build(mesh.vertices, pattern);
  EXPECT_GT(clusters.size(), 4u);

  std::mt19937 rng(kSeed);
  std::normal_distribution<double> normal;
  std::exponential_distribution<double> positive;
  std::vector<Vec3> x = mesh.vertices;
  std::vector<double> v(3 * x.size());
  for (Vec3& p : x) p += 0.2 * Vec3(normal(rng), normal(rng), normal(rng));  // crushed beyond recognition
  for (double& c : v) c = normal(rng);
  std::vector<MotionCluster> found;
  clusters.measure(x, v, 0.0, found);
  ASSERT_EQ(found.size(), clusters.size());
  const auto inside = [](const Aabb& box, const Vec3& p) {
    return ((p - box.lo).array() >= -1e-12).all() && ((box.hi - p).array() >= -1e-12).all();
  };
  for (const Tetrahedron& t : mesh.tets) {
    Eigen::Vector4d w(positive(rng), positive(rng), positive(rng), positive(rng));
    w /= w.sum();
    Vec3 p = Vec3::Zero(), u = Vec3::Zero();
    for (int i = 0; i < 4; ++i) p += w[i] * x[t[i]], u += w[i] * Vec3(v[3 * t[i]], v[3 * t[i] + 1], v[3 * t[i] + 2]);
    bool held = false;
    for (const MotionCluster& c : found) held = held || (inside(c.box, p) && inside(c.velocity, u));
    EXPECT_TRUE(held);
  }
}

}  // namespace
}  // namespace brim::testing
