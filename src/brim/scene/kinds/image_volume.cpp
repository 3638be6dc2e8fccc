#include <algorithm>
#include <cmath>

#include "brim/body/rigid/rigid_body.h"
#include "brim/body/volume/soft_image_body.h"
#include "brim/mesh/areal_mass.h"
#include "brim/mesh/mass_properties.h"
#include "brim/raster/image_shape.h"
#include "brim/scene/carried.h"
#include "brim/scene/chosen_averaging.h"
#include "brim/scene/image_source.h"
#include "brim/scene/kinds.h"
#include "brim/scene/limits.h"

namespace brim {

BodyKind image_volume_kind();

namespace {

/// Cells of a rigid image along a voxel of contact: a ramp of three voxels spans six.
constexpr double kRigidCells = 2.0;
/// Of a deformable image, for the display; each particle takes as many along each axis, and so is as wide as a voxel.
constexpr int kSoftCells = 2;
/// [bytes] that a tetrahedron, and a particle with its weights, take.
constexpr double kBytesPerCarrierTet = 1000.0, kBytesPerParticle = 400.0;

/// [-] Spacings of a soft image's lattice across a part that bends by 95 % of theory: four, less the rounding of its
/// surface.
constexpr double kEnoughSpacings = 3.5;
/// [-] Share averaged in slender matter of fewer: a beam of two bends 3.7 % too little, with 0.8 6.1 %.
constexpr double kShareOfImages = 0.9;

void check_image_volume(const Node& n) {
  check_image_source(n);
  if (n.string("motion") == "rigid") {
    if (n.has("lattice_spacing"))
      throw n.at("lattice_spacing").error("only a deformable volume has a lattice; \"motion\" is \"rigid\"");
    if (n.at("constraints").size() > 0)
      throw n.at("constraints").error("only a deformable volume has points to hold; \"motion\" is \"rigid\"");
  }
  if (n.string("motion") == "deformable") {
    if (!n.has("lattice_spacing"))
      throw n.error(
          "the key \"lattice_spacing\" is missing; a deformable volume rides in tetrahedra of this size, in metres");
    if (n.has("mass")) throw n.at("mass").error("a deformable volume takes \"density\"");
    check_constraints(n.at("constraints"), false);
  }
  if (n.has("density") && n.has("mass")) throw n.at("mass").error("both \"mass\" and \"density\" are given; give one");
}

class RigidImageMaker final : public BodyMaker {
 public:
  RigidImageMaker(const Node& n, const BuildContext& context) : material_(context.material) {
    const ImageSolid solid =
        read_image_solid(n, n.at("transform").number("scale"), kRigidCells, context.world.memory_limit);
    properties_ = !solid.density.empty() ? mass_properties(solid.grid, solid.density)
                                         : mass_properties(solid.grid, n.has("density") ? n.number("density") : 1000.0);
    if (n.has("mass")) {
      properties_.inertia *= n.number("mass") / properties_.mass;
      properties_.mass = n.number("mass");
    }
    surface_ = display_surface(solid.grid);
    part_.voxel_size = solid.voxel_size;
    part_.areal_mass = areal_mass(properties_.mass, properties_.volume, surface_area(surface_), solid.grid.matter_box(),
                                  solid.voxel_size);
    part_.thickness = 6.0 * properties_.volume / surface_area(surface_);
    part_.width = width_of(properties_.volume, part_.thickness, solid.grid.matter_box());
    part_.material = material_;
    shape_ = make_image_shape(solid.grid, part_.thickness);
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    RigidModel model;
    model.kind = "image_volume";
    model.shape = shape_;
    model.center_of_mass = properties_.center;
    model.mass = properties_.mass;
    model.volume = properties_.volume;
    model.inertia = properties_.inertia;
    model.position = place.position;
    model.rotation = place.rotation;
    model.velocity = place.velocity;
    model.angular_velocity = place.angular_velocity;
    model.part = part_;
    model.surface = surface_;
    return std::make_unique<RigidBody>(std::move(model));
  }

 private:
  Material material_;
  MassProperties properties_;
  TriMesh surface_;
  PartInfo part_;
  std::shared_ptr<const Shape> shape_;
};

class SoftImageMaker final : public BodyMaker {
 public:
  SoftImageMaker(const Node& n, const BuildContext& context) : node_(n), material_(context.material) {
    const double scale = n.at("transform").number("scale"), limit = context.world.memory_limit;
    // Each point of a map gathers all particles within its ramp: much finer ones than the world's finest step cost
    // memory by the third power of the ratio, and contact does not see them.
    solid_ = read_image_solid(n, scale, kSoftCells, limit, context.world.voxel_size);
    spacing_ = scale * n.number("lattice_spacing");
    const Node at = n.at("lattice_spacing");
    const Aabb box = solid_.grid.matter_box();
    if (spacing_ > box.extent().maxCoeff())
      throw at.error(fmt::format("{:.6g} m is not allowed; must be at most the matter's largest extent, {:.6g} m",
                                 spacing_, box.extent().maxCoeff()));
    const double volume = mass_properties(solid_.grid, 1.0).volume;
    surface_ = display_surface(solid_.grid);
    averaging_ =
        chosen_averaging(n, {volume, surface_area(surface_), box.extent(), spacing_}, kEnoughSpacings, kShareOfImages);
    if (!solid_.density.empty()) solid_.density = joined_means(solid_.grid, solid_.density, kSoftCells);
    if (!solid_.young.empty()) solid_.young = joined_means(solid_.grid, solid_.young, kSoftCells);
    solid_.grid = joined_cells(solid_.grid, kSoftCells);
    check_count(at, 12.0 * volume / (spacing_ * spacing_ * spacing_), kBytesPerCarrierTet, limit, "tetrahedra");
    check_count(n, volume / std::pow(solid_.grid.spacing, 3), kBytesPerParticle, limit, "particles");
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    ElasticOptions options = read_elastic(node_, place, material_);
    options.voxel_size = solid_.voxel_size;
    options.averaging = averaging_;
    if (node_.at("constraints").size() > 0) {
      // The lattice's nodes are known once it is built.
      const SoftImageBody free(solid_.grid, {}, spacing_, place.rotation, place.position, options,
                               {solid_.density, solid_.young});
      read_constraints(node_.at("constraints"), free.rest_positions(), {}, place.turned, options);
    }
    return std::make_unique<SoftImageBody>(solid_.grid, surface_, spacing_, place.rotation, place.position,
                                           std::move(options), CellMaterial{solid_.density, solid_.young});
  }

 private:
  Node node_;
  Material material_;
  ImageSolid solid_;
  double spacing_ = 0.0, averaging_ = 0.0;
  TriMesh surface_;
};

}  // namespace

BodyKind image_volume_kind() {
  return {"image_volume", check_image_volume, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            if (n.string("motion") == "deformable") return std::make_unique<SoftImageMaker>(n, c);
            return std::make_unique<RigidImageMaker>(n, c);
          }};
}

}  // namespace brim
