#include <algorithm>

#include "brim/body/rigid/rigid_body.h"
#include "brim/mesh/mass_properties.h"
#include "brim/raster/image_shape.h"
#include "brim/scene/image_source.h"
#include "brim/scene/kinds.h"

namespace brim {

BodyKind image_volume_kind();

namespace {

/// Cells of a rigid image along a voxel of contact: a ramp of three voxels spans six.
constexpr double kRigidCells = 2.0;

void check(const Node& n) {
  check_image_source(n);
  if (n.string("motion") == "rigid") {
    if (n.has("lattice_spacing"))
      throw n.at("lattice_spacing").error("only a deformable volume has a lattice; \"motion\" is \"rigid\"");
    if (n.at("constraints").size() > 0)
      throw n.at("constraints").error("only a deformable volume has points to hold; \"motion\" is \"rigid\"");
  }
  if (n.has("density") && n.has("mass")) throw n.at("mass").error("both \"mass\" and \"density\" are given; give one");
}

class RigidImageMaker final : public BodyMaker {
 public:
  RigidImageMaker(const Node& n, const BuildContext& context) : material_(context.material) {
    const ImageSolid solid =
        read_image_solid(n, n.at("transform").number("scale"), kRigidCells, context.world.memory_limit);
    const double density = n.has("density") ? n.number("density") : 1000.0;
    properties_ = mass_properties(solid.grid, density);
    if (n.has("mass")) {
      properties_.inertia *= n.number("mass") / properties_.mass;
      properties_.mass = n.number("mass");
    }
    surface_ = display_surface(solid.grid);
    part_.voxel_size = solid.voxel_size;
    part_.areal_mass = 6.0 * properties_.mass / surface_area(surface_);
    part_.thickness = 6.0 * properties_.volume / surface_area(surface_);
    part_.material = material_;
    shape_ = make_image_shape(solid.grid, part_.thickness);
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    RigidModel model;
    model.kind = "image_volume";
    model.shape = shape_;
    model.center_of_mass = properties_.center;
    model.mass = properties_.mass;
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

}  // namespace

BodyKind image_volume_kind() {
  return {"image_volume", check, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<RigidImageMaker>(n, c);
          }};
}

}  // namespace brim
