#include "brim/contact/cube_contacts.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <random>

#include "brim/mesh/distance_grid.h"
#include "brim/mesh/primitives.h"
#include "brim/raster/grid_shape.h"
#include "support/touching.h"

namespace brim::cube_contacts_test {
namespace {

using testing::Touching;

constexpr unsigned kSeed = 20261122;
/// Single precision of distances of a few metres, over a ramp of a third of a metre.
constexpr double kSingle = 5e-6;

CubeSide side_of(const Shape& shape, const Pose& pose) {
  CubeSide s;
  s.solid = dynamic_cast<const KnownDistance*>(&shape), s.pose = pose;
  return s;
}

std::map<std::array<int, 3>, std::size_t> by_node(const ContactSet& set) {
  std::map<std::array<int, 3>, std::size_t> order;
  for (std::size_t c = 0; c < set.size(); ++c) order[{set.node[c].x(), set.node[c].y(), set.node[c].z()}] = c;
  return order;
}

TEST(CubeContacts, BetweenSolidsAreThoseOfTilesThatAreFilledWhole) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  const double h = 0.1, w = 3 * h;
  DistanceGridOptions fine;
  fine.spacing = h;
  const std::shared_ptr<const Shape> shapes[] = {
      make_box(Vec3(1.1, 0.9, 0.5)), make_sphere(0.6), make_capsule(0.3, 0.7), make_cylinder(0.4, 0.8),
      make_grid_shape(std::make_shared<DistanceGrid>(make_distance_grid(shapes::torus(0.8, 0.3, 48, 24), fine)), 0.6)};
  std::size_t compared = 0, engulfed = 0;
  for (int trial = 0; trial < 150; ++trial) {
    const Shape &a = *shapes[trial % 5], &b = *shapes[trial / 5 % 5];
    Pose pose[2];
    for (Pose& p : pose) {
      const Vec3 axis = Vec3(in(rng), in(rng), in(rng)).normalized();
      p.rotation = Eigen::AngleAxisd(std::numbers::pi * in(rng), axis).toRotationMatrix();
      p.translation = 0.7 * Vec3(in(rng), in(rng), in(rng));
    }
    const double margin = 0.2 * (1.0 + in(rng));
    const Touching plain(a, pose[0], b, pose[1], h, w, margin);
    const Aabb both =
        a.placed_bounds(pose[0]).inflated(0.5 * w).intersection(b.placed_bounds(pose[1]).inflated(0.5 * w));
    if (both.empty()) continue;
    const NodeBox box{(both.lo / h).array().ceil().cast<int>(), (both.hi / h).array().floor().cast<int>()};
    CubeFinds finds;
    ContactSet found;
    found.pairs = plain.contacts.pairs;
    if ((box.lo.array() <= box.hi.array()).all())
      find_between_solids(side_of(a, pose[0]), side_of(b, pose[1]), found.pairs[0], box, finds);
    const PairFinds piece{0, &finds};
    gather({&piece, 1}, found);
    engulfed += static_cast<std::size_t>(found.engulfed);
    const auto want = by_node(plain.contacts), have = by_node(found);
    // Nodes that touch by less than the rounding, and those at the very end of a ramp, may be on either side.
    const auto inside = [&](const Shape& s, const Pose& p, const Vec3& x) {
      return std::abs(std::abs(s.distance(p.to_local(x))) - 0.5 * w) > 1e-3 * h;
    };
    const auto sure = [&](const ContactSet& s, std::size_t c) {
      const Vec3 x = s.node_at(c, h);
      return s.overlap[c] > -margin + 1e-5 && inside(a, pose[0], x) && inside(b, pose[1], x);
    };
    for (const auto& [node, c] : want)
      EXPECT_TRUE(have.contains(node) || !sure(plain.contacts, c)) << "trial " << trial;
    for (const auto& [node, d] : have) {
      const auto it = want.find(node);
      if (it == want.end()) {
        EXPECT_FALSE(sure(found, d)) << "trial " << trial;
        continue;
      }
      const std::size_t c = it->second;
      EXPECT_NEAR(found.overlap[d], plain.contacts.overlap[c], kSingle);
      EXPECT_LT((found.gradient_a[d] - plain.contacts.gradient_a[c]).norm(), kSingle / h);
      EXPECT_LT((found.gradient_b[d] - plain.contacts.gradient_b[c]).norm(), kSingle / h);
      EXPECT_LT((found.curvature_a(d) - plain.contacts.curvature_a(c)).norm(), 10 * kSingle / (h * h) + 0.02 / h);
      // Where the ramp is flat a density tells its distance to half the digits only.
      EXPECT_NEAR(found.depth[d], plain.contacts.depth[c], 3e-3 * h);
      ++compared;
    }
  }
  EXPECT_GT(compared, 5000u);
  EXPECT_GT(engulfed, 0u);
}

TEST(CubeContacts, FewNodesOfSolidsAreSampled) {
  const auto ball = make_sphere(0.5), floor = make_half_space();
  Pose above;
  above.translation = Vec3(0.03, 0.02, 0.495);
  ContactPair pair{0, 1, 0.05, 0.15, 0.02, 0, 0};
  CubeFinds finds;
  const NodeBox box{Vec3i(-12, -12, -2), Vec3i(12, 12, 2)};
  find_between_solids(side_of(*ball, above), side_of(*floor, {}), pair, box, finds);
  EXPECT_GT(finds.contacts.size(), 10u);
  EXPECT_LT(finds.nodes, 2 * 25 * 25 * 5) << "the box has 3125 nodes, of each part";
}

TEST(CubeContacts, ThePlaneOfABoxPointsAsItDoesHoweverItIsTilted) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  const double h = 0.1, w = 3 * h;
  const auto floor = make_box(Vec3(4, 4, 2)), above = make_sphere(1.0);
  double by_densities = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    Pose lower, upper;
    lower.rotation = Eigen::AngleAxisd(0.7 * in(rng), Vec3(in(rng), in(rng), in(rng)).normalized()).toRotationMatrix();
    const Vec3 up = lower.rotation.col(2);
    lower.translation = -1.0 * up + h * Vec3(in(rng), in(rng), in(rng));
    upper.translation = lower.translation + 1.97 * up;
    const NodeBox box{Vec3i::Constant(-8), Vec3i::Constant(8)};
    for (const bool by_distances : {false, true}) {
      CubeSide a = side_of(*floor, lower), b = side_of(*above, upper);
      a.by_distances = b.by_distances = by_distances;
      CubeFinds finds;
      find_between_solids(a, b, ContactPair{0, 1, h, w, 0.2, 0, 0}, box, finds);
      ASSERT_GT(finds.contacts.size(), 20u);
      for (const Contact& c : finds.contacts) {
        const Vec3 n = -c.gradient_a.cast<double>().normalized(),
                   outward = (h * c.node.cast<double>() - upper.translation).normalized();
        const double bend = h * Eigen::Map<const Vec3f>(c.bend_a.data()).norm() / c.gradient_a.norm();
        if (!by_distances) {
          by_densities = std::max(by_densities, (n - up).norm());
          continue;
        }
        EXPECT_LT((n - up).norm(), 1e-4);
        EXPECT_LT(bend, 1e-4);
        // The curvature of a ball is the stencil's error against the size of the ball.
        EXPECT_LT((c.gradient_b.cast<double>().normalized() + outward).norm(), 2e-3);
      }
    }
  }
  EXPECT_GT(by_densities, 5e-3);
}

TEST(CubeContacts, WidestGapIsWhereTheDensitiesJustReach) {
  for (const double margin : {0.0, 0.05, 0.2, 0.4, 0.5, 0.6, 0.85, 1.0}) {
    const double t = widest_gap(margin);
    EXPECT_GE(3 * t * t - 2 * t * t * t, margin - 1e-12);
    if (margin >= 0.5) {
      EXPECT_NEAR(3 * t * t - 2 * t * t * t, margin, 1e-12);
    }
  }
}

}  // namespace
}  // namespace brim::cube_contacts_test
