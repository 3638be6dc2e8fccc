#include <algorithm>

#include "brim/body/cloth/cloth_body.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/topology.h"
#include "brim/scene/constraints.h"
#include "brim/scene/given_arrays.h"
#include "brim/scene/kinds.h"
#include "brim/scene/limits.h"
#include "brim/scene/particle_options.h"
#include "brim/scene/sheet_grid.h"

namespace brim {

BodyKind cloth_kind();

namespace {

/// [bytes] that a cell with its node, matrix blocks and state takes.
constexpr double kBytesPerClothCell = 2000.0;

void check_cloth(const Node& n) {
  if (n.has("grid") && n.has("mesh")) throw n.at("mesh").error("both \"grid\" and \"mesh\" are given; give one");
  if (!n.has("grid") && !n.has("mesh")) throw n.error("the sheet is missing; give \"grid\" or \"mesh\"");
  check_constraints(n.at("constraints"), n.has("grid"));
}

double mean_edge(const TriMesh& mesh) {
  const std::vector<Edge> all = edges(mesh.triangles);
  double sum = 0.0;
  for (const Edge& e : all)
    sum += (mesh.vertices[static_cast<std::size_t>(e[0])] - mesh.vertices[static_cast<std::size_t>(e[1])]).norm();
  return sum / static_cast<double>(all.size());
}

class ClothMaker final : public BodyMaker {
 public:
  ClothMaker(const Node& n, const BuildContext& context) : node_(n), material_(context.material) {
    const double scale = n.at("transform").number("scale"), limit = context.world.memory_limit;
    if (n.has("grid")) {
      SheetGrid grid = read_sheet_grid(n.at("grid"), scale, kBytesPerClothCell, limit);
      mesh_ = shapes::grid(grid.nx, grid.ny, grid.lx, grid.ly);
      corners_ = std::move(grid.corners);
    } else {
      mesh_ = named_surface(n.at("mesh"));
      for (Vec3& x : mesh_.vertices) x *= scale;
    }
    const double voxel = n.number("voxel_size");
    thickness_ = n.number("thickness");
    if (thickness_ <= 0.0) thickness_ = voxel > 0.0 ? 2.0 * voxel : mean_edge(mesh_);
    check_voxel_size(n, voxel > 0.0 ? voxel : 0.5 * thickness_, 2.0 * surface_area(mesh_), limit);
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    TriMesh mesh = mesh_;
    for (Vec3& x : mesh.vertices) x = place.position + place.rotation * x;
    ClothOptions options;
    options.areal_density = node_.number("areal_density");
    options.thickness = thickness_;
    options.membrane.young = node_.number("stretch_stiffness");
    options.membrane.young_weft = node_.number("weft_stiffness");
    options.membrane.poisson = node_.number("poisson_ratio");
    options.membrane.shear = node_.number("shear_stiffness");
    options.membrane.warp = place.rotation * Vec3::UnitX();
    options.bending = node_.number("bend_stiffness");
    read_particle_options(node_, place, material_, options);
    options.self_contact = node_.boolean("self_contact");
    read_constraints(node_.at("constraints"), mesh.vertices, corners_, place.turned, options);
    return std::make_unique<ClothBody>(std::move(mesh), std::move(options));
  }

 private:
  Node node_;
  Material material_;
  TriMesh mesh_;  ///< scaled, not placed
  std::vector<std::int32_t> corners_;
  double thickness_ = 0.0;  ///< [m]
};

}  // namespace

BodyKind cloth_kind() {
  return {"cloth", check_cloth, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<ClothMaker>(n, c);
          }};
}

}  // namespace brim
