#include "brim/scene/solid_store.h"

#include <gtest/gtest.h>

#include "brim/body/distance_bound.h"
#include "brim/body/posed_shape.h"
#include "brim/mesh/primitives.h"
#include "brim/raster/known_distance.h"
#include "brim/scene/scene.h"

/// Equal surfaces in equal voxels are sampled once, as long as a body has them.
namespace brim::solid_store_test {
namespace {

constexpr double kLimit = 1e8;

Solid sampled(SolidStore& store, const TriMesh& mesh, double voxel_size,
              SurfaceTreatment treatment = SurfaceTreatment::Closed) {
  Solid solid;
  solid.voxel_size = voxel_size;
  store.make({mesh, treatment, 0.0}, kLimit, solid);
  return solid;
}

TEST(SolidStore, SharesEqualSurfacesInEqualVoxelsOnly) {
  SolidStore store;
  const TriMesh torus = shapes::torus(0.4, 0.1, 24, 12);
  TriMesh other = torus;
  other.vertices[7] *= 1.0001;
  const Solid first = sampled(store, torus, 0.05), again = sampled(store, torus, 0.05);
  EXPECT_EQ(again.shape, first.shape);
  EXPECT_EQ(again.unit.mass, first.unit.mass);
  EXPECT_EQ(again.unit.inertia, first.unit.inertia);
  EXPECT_NE(sampled(store, torus, 0.04).shape, first.shape);
  EXPECT_NE(sampled(store, other, 0.05).shape, first.shape);
  EXPECT_NE(sampled(store, torus, 0.05, SurfaceTreatment::WindingNumber).shape, first.shape);
}

TEST(SolidStore, KeepsNoSolidAlive) {
  SolidStore store;
  const TriMesh torus = shapes::torus(0.4, 0.1, 24, 12);
  const std::weak_ptr<const Shape> gone = sampled(store, torus, 0.05).shape;
  EXPECT_TRUE(gone.expired());
  EXPECT_NE(sampled(store, torus, 0.05).shape, nullptr);
}

TEST(SolidStore, KnowsAConvexPolyhedronExactly) {
  SolidStore store;
  const auto slack = [&](const TriMesh& mesh, SurfaceTreatment treatment) {
    return dynamic_cast<const KnownDistance&>(*sampled(store, mesh, 0.05, treatment).shape).slack();
  };
  const TriMesh block = shapes::box(Vec3(0.3, 0.5, 0.7), 3);
  EXPECT_EQ(slack(block, SurfaceTreatment::Closed), 0.0);
  EXPECT_GT(slack(block, SurfaceTreatment::WindingNumber), 0.0);
  EXPECT_GT(slack(shapes::icosphere(0.3), SurfaceTreatment::Closed), 0.0);
  EXPECT_NEAR(sampled(store, block, 0.05).unit.mass, 0.105, 1e-12);
}

TEST(SolidStore, BodiesOfASceneShareTheirShapes) {
  const Scene scene = parse_scene(
      R"({"brim": 1, "name": "two", "frames": 1, "bodies": [
        {"kind": "rigid", "name": "a", "shape": {"kind": "blob", "radius": 0.4}},
        {"kind": "obstacle", "name": "b", "shape": {"kind": "blob", "radius": 0.4}}]})",
      "two.json");
  SolidStore store;
  const auto bodies = build_bodies(scene, store);
  ASSERT_EQ(bodies.size(), 2u);
  const auto solid = [&](std::size_t b) {
    return dynamic_cast<const DistanceBound&>(*bodies[b]).solid(0)->known_distance();
  };
  EXPECT_EQ(solid(0), solid(1));
}

}  // namespace
}  // namespace brim::solid_store_test
