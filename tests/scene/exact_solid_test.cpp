#include "brim/scene/exact_solid.h"

#include <gtest/gtest.h>

#include "brim/mesh/primitives.h"
#include "brim/scene/document.h"
#include "brim/scene/node.h"
#include "brim/scene/scene.h"

/// Formulas of shapes against meshes of their surfaces.
namespace brim::exact_solid_test {
namespace {

/// The body of a scene with this shape, which is its only one.
ExactSolid solid_of(const std::string& shape, double scale) {
  const Scene scene = parse_scene(
      R"({"brim": 1, "name": "one", "frames": 1, "bodies": [{"kind": "rigid", "name": "a", "shape": )" + shape + "}]}",
      "one.json");
  const Node list(*scene.document, scene.document->root.at("bodies"), "/bodies");
  const auto solid = exact_solid(list.at(std::size_t{0}).at("shape"), scale);
  EXPECT_TRUE(solid.has_value()) << shape;
  return solid.value_or(ExactSolid{});
}

TEST(ExactSolid, HasTheMatterOfItsMesh) {
  const int fine = 1024;
  const struct {
    std::string shape;
    TriMesh mesh;  ///< of twice the size
  } samples[] = {
      {R"({"kind": "sphere", "radius": 0.35})", shapes::icosphere(0.7, 6)},
      {R"({"kind": "cylinder", "radius": 0.25, "length": 0.2})", shapes::cylinder(0.5, 0.4, fine)},
      {R"({"kind": "capsule", "radius": 0.15, "length": 0.4})", shapes::capsule(0.3, 0.8, fine)},
      {R"({"kind": "torus", "radius": 0.25, "tube": 0.1})", shapes::torus(0.5, 0.2, fine, fine)},
      {R"({"kind": "bowl", "radius": 0.3, "thickness": 0.05})", shapes::bowl(0.6, 0.1, fine)},
      {R"({"kind": "cup", "radius": 0.2, "height": 0.3, "thickness": 0.05})", shapes::cup(0.4, 0.6, 0.1, fine)},
  };
  for (const auto& sample : samples) {
    SCOPED_TRACE(sample.shape);
    const ExactSolid solid = solid_of(sample.shape, 2.0);
    const MassProperties mesh = mass_properties(sample.mesh, 1.0);
    EXPECT_NEAR(solid.unit.mass / mesh.mass, 1.0, 1e-3);
    EXPECT_NEAR(solid.area / surface_area(sample.mesh), 1.0, 1e-3);
    EXPECT_LT((solid.unit.center - mesh.center).norm(), 3e-4);
    EXPECT_LT((solid.unit.inertia - mesh.inertia).norm(), 1.5e-3 * mesh.inertia.norm());
  }
}

}  // namespace
}  // namespace brim::exact_solid_test
