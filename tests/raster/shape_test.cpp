#include "brim/raster/shape.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

#include "brim/core/error.h"
#include "brim/math/ramp.h"
#include "brim/math/rotation.h"
#include "brim/mesh/distance.h"
#include "brim/mesh/primitives.h"
#include "brim/raster/convex_distance.h"
#include "support/tiles.h"

namespace brim::shape_test {
namespace {

using testing::expect_present;
using testing::for_each_node;
using testing::tiles_around;

constexpr unsigned kSeed = 61;

/// A finite shape and a fine triangle mesh of its surface, made by other code.
struct Sample {
  const char* name;
  std::shared_ptr<const Shape> shape;
  TriMesh mesh;
  double sagitta;  ///< [m] the mesh may lie this far inside the surface; where that is hollow, outside
};

std::vector<Sample> samples() {
  const double fine = 1.0 - std::cos(std::numbers::pi / 256);
  return {{"sphere", make_sphere(0.7), shapes::icosphere(0.7, 5), 0.7 * 1e-3},
          {"box", make_box(Vec3(1.0, 0.6, 0.3)), shapes::box(Vec3(1.0, 0.6, 0.3)), 1e-12},
          {"capsule", make_capsule(0.3, 0.8), shapes::capsule(0.3, 0.8, 256), 0.3 * 2 * fine},
          {"cylinder", make_cylinder(0.5, 0.4), shapes::cylinder(0.5, 0.4, 256), 0.5 * fine},
          {"torus", make_torus(0.5, 0.2), shapes::torus(0.5, 0.2, 256, 256), 0.7 * 2 * fine},
          {"bowl", make_bowl(0.6, 0.2), shapes::bowl(0.6, 0.2, 256), 0.1 * 0.04},
          {"cup", make_cup(0.5, 0.7, 0.2), shapes::cup(0.5, 0.7, 0.2, 256), 0.5 * fine}};
}

struct Dice {
  std::mt19937 rng{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};
  Vec3 vector(double scale = 1.0) {
    const double x = uniform(rng), y = uniform(rng);
    return scale * Vec3(x, y, uniform(rng));
  }
  Pose pose() { return {rotation_from_vector(vector(3.0)).toRotationMatrix(), vector(2.0)}; }
};

TEST(Shape, DistancesByHand) {
  EXPECT_DOUBLE_EQ(make_sphere(2.0)->distance(Vec3(0, 3, 4)), 3.0);
  EXPECT_DOUBLE_EQ(make_box(Vec3(2, 4, 6))->distance(Vec3(4, 6, 0)), 5.0);
  EXPECT_DOUBLE_EQ(make_box(Vec3(2, 4, 6))->distance(Vec3(0.25, 0, 0)), -0.75);
  EXPECT_DOUBLE_EQ(make_capsule(1.0, 2.0)->distance(Vec3(3, 0, 5)), 4.0);
  EXPECT_DOUBLE_EQ(make_cylinder(1.0, 2.0)->distance(Vec3(0, 4, 5)), 5.0);
  EXPECT_DOUBLE_EQ(make_cylinder(1.0, 2.0)->distance(Vec3(0, 0.25, 0.5)), -0.5);
  EXPECT_DOUBLE_EQ(make_half_space()->distance(Vec3(7, 8, -3)), -3.0);
}

TEST(Shape, DistanceEqualsTheDistanceToATriangulatedSurface) {
  SCOPED_TRACE(kSeed);
  Dice dice;
  for (const Sample& s : samples()) {
    SCOPED_TRACE(s.name);
    const SurfaceTree tree(s.mesh);
    const bool convex = dynamic_cast<const ConvexDistance*>(s.shape.get()) != nullptr;
    for (int i = 0; i < 500; ++i) {
      const Vec3 p = dice.vector(i % 2 ? 1.0 : 0.5);
      const double measured = tree.signed_distance(p);
      EXPECT_LE(s.shape->distance(p), measured + (convex ? 0.0 : s.sagitta) + 1e-9);
      EXPECT_GE(s.shape->distance(p), measured - s.sagitta - 1e-9);
    }
  }
}

TEST(Shape, BoundsHoldTheSurfaceAndTouchIt) {
  Dice dice;
  for (const Sample& s : samples()) {
    SCOPED_TRACE(s.name);
    Aabb box;
    for (const Vec3& p : s.mesh.vertices) box.extend(p);
    const Aabb b = s.shape->bounds();
    EXPECT_LT((b.lo - box.lo).cwiseAbs().maxCoeff(), s.sagitta + 1e-9);
    EXPECT_LT((b.hi - box.hi).cwiseAbs().maxCoeff(), s.sagitta + 1e-9);
    EXPECT_LE(s.shape->thickness(), b.extent().minCoeff() + 1e-12);
    for (int i = 0; i < 20; ++i) {
      const Pose pose = dice.pose();
      const Aabb placed = s.shape->placed_bounds(pose).inflated(1e-12);
      for (const Vec3& p : s.mesh.vertices) {
        const Vec3 x = pose.rotation * p + pose.translation;
        EXPECT_TRUE((x.array() >= placed.lo.array()).all() && (x.array() <= placed.hi.array()).all());
      }
    }
  }
}

TEST(Shape, HalfSpaceIsBoundedOnItsOpenSideWhenAlignedWithAnAxis) {
  const auto plane = make_half_space();
  Pose pose;
  pose.translation = Vec3(1, 2, 3);
  EXPECT_EQ(plane->placed_bounds(pose).hi.z(), 3.0);
  EXPECT_EQ(plane->placed_bounds(pose).lo.z(), -std::numeric_limits<double>::infinity());
  pose.rotation = rotation_from_vector(Vec3(0.3, 0, 0)).toRotationMatrix();
  EXPECT_EQ(plane->placed_bounds(pose).hi.z(), std::numeric_limits<double>::infinity());
}

TEST(Shape, DensityIsTheRampOfTheDistanceAtEveryNodeOfABlock) {
  SCOPED_TRACE(kSeed);
  Dice dice;
  auto all = samples();
  all.push_back({"half-space", make_half_space(), {}, 0.0});
  for (const Sample& s : all) {
    SCOPED_TRACE(s.name);
    for (int i = 0; i < 3; ++i) {
      const double h = 0.06, w = 3 * h;
      const Pose pose = dice.pose();
      Aabb region{pose.translation - Vec3::Constant(1.3), pose.translation + Vec3::Constant(1.3)};
      const auto tiles = tiles_around(region, h);
      std::vector<DensityBlock> blocks(tiles.size());
      for (std::size_t t = 0; t < tiles.size(); ++t) s.shape->fill(pose, tiles[t], h, w, blocks[t]);
      double error = 0.0, most = 0.0, least = 1.0;
      for_each_node(tiles, h, [&](std::size_t t, int node, const Vec3& x) {
        const double rho = blocks[t].rho[node];
        error = std::max(error, std::abs(rho - ramp(s.shape->distance(pose.to_local(x)), w)));
        most = std::max(most, rho);
        least = std::min(least, rho);
      });
      EXPECT_LT(error, 1e-12);
      EXPECT_EQ(most, 1.0);
      EXPECT_EQ(least, 0.0);
    }
  }
}

TEST(Shape, DensityIsOneHalfOnTheSurface) {
  SCOPED_TRACE(kSeed);
  Dice dice;
  const double h = 0.05, w = 3 * h;
  const int node = block_index(4, 5, 3);
  const Vec3 x = block_origin({0, 0, 0}, h) + h * Vec3(4, 5, 3);
  for (const Sample& s : samples())
    for (std::size_t i = 0; i < s.mesh.vertices.size(); i += 1 + s.mesh.vertices.size() / 50) {
      Pose pose = dice.pose();
      pose.translation = x - pose.rotation * s.mesh.vertices[i];  // this point of the surface comes to the node
      DensityBlock block;
      s.shape->fill(pose, {0, 0, 0}, h, w, block);
      EXPECT_NEAR(block.rho[node], 0.5, 1.5 / w * 1e-9) << s.name;
    }
}

/// Every tile of the region whose block has density must be listed, for the shape anywhere.
void expect_presence(const char* name, const Shape& shape, double h, double w, const Pose& pose, const Aabb& region) {
  SCOPED_TRACE(name);
  std::vector<TileKey> present;
  shape_presence(shape, pose, h, w, region, present);
  std::vector<TileKey> tiles;
  const TileRange r = tiles_meeting(region, h);
  for (int z = r.lo.z; z <= r.hi.z; ++z)
    for (int y = r.lo.y; y <= r.hi.y; ++y)
      for (int x = r.lo.x; x <= r.hi.x; ++x) tiles.push_back({x, y, z});
  std::vector<DensityBlock> blocks(tiles.size());
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    // The definition at every node, not fill(), which has a shortcut of its own.
    for_each_node({tiles[t]}, h, [&](std::size_t, int node, const Vec3& x) {
      blocks[t].rho[node] = ramp(shape.distance(pose.to_local(x)), w);
    });
  }
  expect_present(tiles, blocks, present);
}

TEST(Shape, PresenceListsEveryTileWhoseBlockHasDensity) {
  SCOPED_TRACE(kSeed);
  Dice dice;
  auto all = samples();
  all.push_back({"half-space", make_half_space(), {}, 0.0});
  all.push_back({"small sphere", make_sphere(0.05), {}, 0.0});
  all.push_back({"thin box", make_box(Vec3(1.0, 1.0, 0.02)), {}, 0.0});
  for (const Sample& s : all)
    for (int i = 0; i < 12; ++i) {
      const Pose pose = dice.pose();
      const double h = 0.06;
      const Aabb region{pose.translation - Vec3::Constant(1.3), pose.translation + Vec3::Constant(1.3)};
      expect_presence(s.name, *s.shape, h, (i % 3 + 2) * h, pose, region);
    }
}

TEST(Shape, PresenceListsNoTileFarFromTheShape) {
  SCOPED_TRACE(kSeed);
  Dice dice;
  const double h = 0.06, w = 3 * h;
  for (const Sample& s : samples())
    for (int i = 0; i < 10; ++i) {
      const Pose pose = dice.pose();
      std::vector<TileKey> present;
      const double inf = std::numeric_limits<double>::infinity();
      shape_presence(*s.shape, pose, h, w, {Vec3::Constant(-inf), Vec3::Constant(inf)}, present);
      EXPECT_FALSE(present.empty());
      for (const TileKey& t : present) {
        const double half_diagonal = 0.5 * (kBlockSize - 1) * h * std::sqrt(3.0);
        EXPECT_LE(s.shape->distance(pose.to_local(tile_box(t, h).center())), half_diagonal + 0.5 * w + 1e-12);
      }
    }
}

TEST(Shape, PresenceStaysInTheRegion) {
  std::vector<TileKey> present;
  shape_presence(*make_half_space(), {}, 0.1, 0.3, {Vec3(0, 0, -0.75), Vec3(0.75, 0.75, 0.0)}, present);
  for (const TileKey& t : present) EXPECT_TRUE(t.x == 0 && t.y == 0 && (t.z == -1 || t.z == 0));
  EXPECT_EQ(present.size(), 2u);
  present.clear();
  shape_presence(*make_sphere(1.0), {}, 0.1, 0.3, {Vec3(5, 5, 5), Vec3(6, 6, 6)}, present);
  EXPECT_TRUE(present.empty());
}

TEST(Shape, GradientsAreTheDerivativesOfDistances) {
  SCOPED_TRACE(kSeed);
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  std::vector<std::shared_ptr<const Shape>> shapes{make_half_space()};
  for (const Sample& s : samples())
    if (dynamic_cast<const ConvexDistance*>(s.shape.get()) != nullptr) shapes.push_back(s.shape);
  EXPECT_EQ(shapes.size(), 5u);
  for (const auto& shape : shapes) {
    const auto* convex = dynamic_cast<const ConvexDistance*>(shape.get());
    ASSERT_NE(convex, nullptr);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 p(u(rng), u(rng), u(rng)), q(u(rng), u(rng), u(rng));
      Vec3 g, at_q;
      const double d = convex->distance_and_gradient(p, g), e = convex->distance_and_gradient(q, at_q);
      EXPECT_EQ(d, shape->distance(p));
      EXPECT_NEAR(g.norm(), 1.0, 1e-12);
      // Distances to a convex solid are convex.
      EXPECT_GE(e, d + g.dot(q - p) - 1e-12);
      if (d <= 0.01) continue;  // inside there are creases
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 step = 1e-6 * Vec3::Unit(axis);
        // Curvature there is at most 1/d: half of it over the step, and rounding.
        EXPECT_NEAR(g[axis], (shape->distance(p + step) - shape->distance(p - step)) / 2e-6, 1e-6 / d + 1e-9);
      }
    }
  }
}

TEST(Shape, SizesMustBePositiveAndFinite) {
  EXPECT_THROW(make_sphere(0.0), InputError);
  EXPECT_THROW(make_box(Vec3(1, -1, 1)), InputError);
  EXPECT_THROW(make_capsule(1.0, std::numeric_limits<double>::quiet_NaN()), InputError);
  EXPECT_THROW(make_cylinder(std::numeric_limits<double>::infinity(), 1.0), InputError);
}

}  // namespace
}  // namespace brim::shape_test
