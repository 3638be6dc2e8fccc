#include "brim/contact/contact_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "brim/core/parallel.h"
#include "brim/math/ramp.h"
#include "support/detect.h"
#include "support/touching.h"

namespace brim::contact_set_test {
namespace {

using testing::detect;
using testing::PairTile;
using testing::plane_pose;
using testing::Touching;

constexpr unsigned kSeed = 72;
/// Contacts are kept in single precision: a few units in the last place of numbers up to 1.
constexpr double kSingle = 1e-6;
/// Distances read from densities lose half of the digits where the ramp is flat: the root of single precision.
constexpr double kSteep = 3e-4;

/// Blocks of random densities with many full and empty nodes, two pairs on overlapping tiles.
struct RandomBlocks {
  std::vector<DensityBlock> blocks;
  std::vector<PairTile> tiles;
  ContactSet set;

  explicit RandomBlocks(int per_pair) {
    std::mt19937 rng(kSeed);
    std::uniform_real_distribution<double> value(-0.8, 1.8);
    std::uniform_int_distribution<int> half(0, 1);
    blocks.resize(4 * per_pair);
    for (DensityBlock& b : blocks) {
      const bool full = half(rng);
      for (int i = 0; i < kBlockNodes; ++i) {
        b.rho[i] = std::clamp(value(rng) + (full ? 1.3 : 0.0), 0.0, 1.0);
        b.source[i] = static_cast<int>(rng() % 1000);
      }
    }
    set.pairs.push_back({0, 1, 0.1, 0.3, 0.0, 0, 0});
    set.pairs.push_back({0, 2, 0.2, 0.5, 0.3, 0, 0});
    for (int pair = 0; pair < 2; ++pair)
      for (int t = 0; t < per_pair; ++t) {
        const std::size_t first = 2 * (pair * per_pair + t);
        tiles.push_back({pair, {t, -t, 2 * pair}, &blocks[first], &blocks[first + 1]});
      }
    detect(tiles, set);
  }
};

/// The stencils written out.
Vec3 gradient(const DensityBlock& b, int i, int j, int k, double h) {
  const double smooth[3] = {3.0 / 16, 10.0 / 16, 3.0 / 16}, slope[3] = {-0.5, 0, 0.5};
  Vec3 g = Vec3::Zero();
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      for (int e = 0; e < 3; ++e)
        g += b.rho[block_index(i + c - 1, j + d - 1, k + e - 1)] *
             Vec3(slope[c] * smooth[d] * smooth[e], smooth[c] * slope[d] * smooth[e], smooth[c] * smooth[d] * slope[e]);
  return g / h;
}

Mat3 hessian(const DensityBlock& b, int i, int j, int k, double h) {
  const double smooth[3] = {3.0 / 16, 10.0 / 16, 3.0 / 16}, slope[3] = {-0.5, 0, 0.5}, bend[3] = {1, -2, 1};
  Mat3 H = Mat3::Zero();
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d)
      for (int e = 0; e < 3; ++e) {
        const double rho = b.rho[block_index(i + c - 1, j + d - 1, k + e - 1)];
        const double xy = slope[c] * slope[d] * smooth[e], xz = slope[c] * smooth[d] * slope[e],
                     yz = smooth[c] * slope[d] * slope[e];
        Mat3 m;
        m << bend[c] * smooth[d] * smooth[e], xy, xz, xy, smooth[c] * bend[d] * smooth[e], yz, xz, yz,
            smooth[c] * smooth[d] * bend[e];
        H += rho * m;
      }
  return H / (h * h);
}

bool flat(const DensityBlock& b, int i, int j, int k) {
  for (const Vec3i& d : {Vec3i(0, 0, 0), Vec3i(1, 0, 0), Vec3i(-1, 0, 0), Vec3i(0, 1, 0), Vec3i(0, -1, 0),
                         Vec3i(0, 0, 1), Vec3i(0, 0, -1)})
    if (b.rho[block_index(i + d.x(), j + d.y(), k + d.z())] < 1.0) return false;
  return true;
}

TEST(ContactSet, DetectFindsWhatASearchOfEveryNodeFinds) {
  SCOPED_TRACE(kSeed);
  const RandomBlocks r(5);
  std::size_t count = 0;
  std::int64_t engulfed = 0;
  for (std::size_t p = 0; p < r.set.pairs.size(); ++p) {
    const ContactPair& pair = r.set.pairs[p];
    EXPECT_EQ(pair.begin, count);
    std::map<std::array<int, 3>, std::size_t> by_node;
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      const Vec3i& n = r.set.node[c];
      EXPECT_TRUE(by_node.insert({{n.x(), n.y(), n.z()}, c}).second);
    }
    for (const PairTile& t : r.tiles) {
      if (t.pair != static_cast<int>(p)) continue;
      for (int k = 1; k <= kTileSize; ++k)
        for (int j = 1; j <= kTileSize; ++j)
          for (int i = 1; i <= kTileSize; ++i) {
            const int node = block_index(i, j, k);
            const double a = t.a->rho[node], b = t.b->rho[node];
            const bool slopes = a > 0 && a < 1 && b > 0 && b < 1;
            if (!(a + b > 1.0 || (a + b > 1.0 - pair.margin && slopes))) continue;
            if (flat(*t.a, i, j, k) && flat(*t.b, i, j, k)) {
              ++engulfed;
              continue;
            }
            const Vec3 x = block_origin(t.tile, pair.h) + pair.h * Vec3(i, j, k);
            const auto found = by_node.find({8 * t.tile.x + i - 1, 8 * t.tile.y + j - 1, 8 * t.tile.z + k - 1});
            ASSERT_NE(found, by_node.end());
            const std::size_t c = found->second;
            EXPECT_LT((r.set.node_at(c, pair.h) - x).norm(), 1e-12);
            EXPECT_NEAR(r.set.overlap[c], a + b - 1.0, kSingle);
            const Vec3 ga = gradient(*t.a, i, j, k, pair.h), gb = gradient(*t.b, i, j, k, pair.h);
            EXPECT_LT((r.set.gradient_a[c] - ga).norm(), kSingle / pair.h);
            EXPECT_LT((r.set.gradient_b[c] - gb).norm(), kSingle / pair.h);
            const double da = ramp_inverse(a, pair.w), db = ramp_inverse(b, pair.w);
            EXPECT_NEAR(r.set.depth[c], -(da + db), kSteep * pair.w);
            if ((ga - gb).norm() > 0.1) {
              EXPECT_LT((r.set.point[c] - x - 0.5 * (da - db) * (ga - gb).normalized()).norm(), 2 * kSteep * pair.w);
            }
            const Mat3 H = hessian(*t.a, i, j, k, pair.h),
                       T = Mat3::Identity() - ga * ga.transpose() / ga.squaredNorm();
            if (pair.h * ga.norm() > 0.1) {  // its direction is known to ten times the rounding
              EXPECT_LT((r.set.curvature_a(c) - T * H * T).norm(), 10 * kSingle * (1.0 + H.norm())) << "tangential";
            }
            EXPECT_EQ(r.set.source_a[c], t.a->source[node]);
            EXPECT_EQ(r.set.source_b[c], t.b->source[node]);
            ++count;
          }
    }
    EXPECT_EQ(pair.end, count);
  }
  EXPECT_EQ(count, r.set.size());
  EXPECT_EQ(engulfed, r.set.engulfed);
  EXPECT_GT(count, 1000u);
}

TEST(ContactSet, AnyNumberOfThreadsGivesTheSameContacts) {
  const RandomBlocks all(40);
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    const RandomBlocks r(40);
    EXPECT_EQ(r.set.node, all.set.node);
    EXPECT_EQ(r.set.point, all.set.point);
    EXPECT_EQ(r.set.gradient_a, all.set.gradient_a);
    EXPECT_EQ(r.set.bend_b, all.set.bend_b);
  }
}

TEST(ContactSet, ShiftByWholeVoxelsShiftsTheContactsExactly) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_int_distribution<int> voxels(-30, 30), sub(0, 1023);
  const double h = 0.125, w = 3 * h;  // dyadic, so that positions are exact
  const auto sphere = make_sphere(0.75), box = make_box(Vec3(2, 2, 1));
  const auto by_node = [h](const Touching& t, const Vec3& back) {
    std::map<std::array<double, 3>, std::size_t> order;
    for (std::size_t c = 0; c < t.contacts.size(); ++c) {
      const Vec3 x = t.contacts.node_at(c, h) - back;
      order[{x.x(), x.y(), x.z()}] = c;
    }
    return order;
  };
  for (int trial = 0; trial < 5; ++trial) {
    Pose a, b;
    a.translation = Vec3(sub(rng), sub(rng), sub(rng)) / 8192.0;
    b.translation = Vec3(0, 0, -1.125);
    Vec3 shift;
    for (double& s : shift) s = h * voxels(rng);
    const Touching before(*sphere, a, *box, b, h, w, 0.2);
    a.translation += shift, b.translation += shift;
    const Touching after(*sphere, a, *box, b, h, w, 0.2);
    ASSERT_GT(before.contacts.size(), 20u);
    ASSERT_EQ(before.contacts.size(), after.contacts.size());
    const auto was = by_node(before, Vec3::Zero()), is = by_node(after, shift);
    ASSERT_EQ(was.size(), before.contacts.size()) << "each node is found once";
    for (const auto& [x, c] : was) {
      const auto found = is.find(x);
      ASSERT_NE(found, is.end());
      const std::size_t d = found->second;
      EXPECT_EQ(before.contacts.overlap[c], after.contacts.overlap[d]);
      EXPECT_EQ(before.contacts.gradient_a[c], after.contacts.gradient_a[d]);
      EXPECT_EQ(before.contacts.curvature_b(c), after.contacts.curvature_b(d));
      EXPECT_LT((before.contacts.point[c] + shift - after.contacts.point[d]).norm(), 1e-14);
    }
  }
}

TEST(ContactSet, PointLiesWhereTheDistancesToTwoParallelPlanesAgree) {
  const double h = 0.1, w = 3 * h;
  const auto plane = make_half_space();
  const auto block = make_box(Vec3(2, 2, 2));
  struct Case {
    Vec3 n;
    double bound;  ///< [m]
  };
  // Tilted: the direction of a single node's gradient errs by up to 1.5 %, over a shift of half a ramp.
  for (const auto& [n, bound] : {Case{Vec3(0, 0, 1), kSteep * w}, Case{Vec3(0.3, 0.2, 1).normalized(), 0.002 * h}}) {
    const double overlap = 0.4 * h;
    const Pose ground = plane_pose(n, Vec3(0.013, 0.02, 0.031));
    Pose above = ground;
    above.translation += (1.0 - overlap) * n;
    const Touching t(*block, above, *plane, ground, h, w);
    ASSERT_GT(t.contacts.size(), 100u);
    std::size_t checked = 0;
    for (std::size_t c = 0; c < t.contacts.size(); ++c) {
      const Vec3 local = above.to_local(t.contacts.node_at(c, h));
      if (local.head<2>().cwiseAbs().maxCoeff() > 1.0 - w - 2 * h) continue;  // only far from the block's edges
      // Beyond its ramp a density tells no distance: only nodes on both slopes know where to go.
      const double at_a = block->distance(local), at_b = plane->distance(ground.to_local(t.contacts.node_at(c, h)));
      if (std::abs(at_a) > 0.5 * w || std::abs(at_b) > 0.5 * w) {
        EXPECT_LT(t.contacts.depth[c], overlap) << "a node beyond a ramp never overstates the depth";
        continue;
      }
      const double da = block->distance(above.to_local(t.contacts.point[c]));
      const double db = plane->distance(ground.to_local(t.contacts.point[c]));
      EXPECT_NEAR(da, db, bound);
      EXPECT_NEAR(t.contacts.depth[c], overlap, kSteep * w);
      ++checked;
    }
    EXPECT_GT(checked, 100u);
  }
}

TEST(ContactSet, ASeparatedPairHasNoContact) {
  const auto sphere = make_sphere(0.5);
  Pose b;
  b.translation = Vec3(1.31, 0, 0);  // more than a ramp apart
  EXPECT_EQ(Touching(*sphere, {}, *sphere, b, 0.1, 0.3).contacts.size(), 0u);
  b.translation = Vec3(1.0001, 0, 0);  // touching surfaces, no overlap
  EXPECT_EQ(Touching(*sphere, {}, *sphere, b, 0.1, 0.3).contacts.size(), 0u);
}

TEST(ContactSet, NodesDeepInsideTwoPartsAreCountedAsEngulfed) {
  const auto big = make_sphere(2.0), small = make_sphere(0.5);
  const Touching t(*small, {}, *big, {}, 0.1, 0.3);
  EXPECT_GT(t.contacts.engulfed, 50);
  Vec3 sum = Vec3::Zero();
  for (std::size_t c = 0; c < t.contacts.size(); ++c)
    sum += t.contacts.overlap[c] * (t.contacts.gradient_a[c] - t.contacts.gradient_b[c]);
  EXPECT_LT(sum.norm(), 1e-9) << "an engulfed body feels no net force (paper, section 8)";
}

TEST(ContactSet, NoTilesGiveNoContacts) {
  ContactSet set;
  set.pairs.push_back({0, 1, 0.1, 0.3, 0.0, 5, 9});
  detect({}, set);
  EXPECT_EQ(set.size(), 0u);
  EXPECT_EQ(set.pairs[0].begin, set.pairs[0].end);
}

}  // namespace
}  // namespace brim::contact_set_test
