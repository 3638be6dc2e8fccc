#include "brim/body/rigid/rigid_body.h"
#include "brim/scene/kinds.h"
#include "brim/scene/solid.h"

namespace brim {

BodyKind rigid_kind();

namespace {

void check_rigid(const Node& n) {
  if (n.has("density") && n.has("mass")) throw n.at("mass").error("both \"mass\" and \"density\" are given; give one");
  refuse_plane(n.at("shape"), "mass");
  check_shape(n.at("shape"));
}

class RigidMaker final : public BodyMaker {
 public:
  RigidMaker(const Node& n, const BuildContext& context)
      : solid_(read_solid(n, context.world.memory_limit, context.solids)), material_(context.material) {
    const double density = n.has("density") ? n.number("density") : 1000.0;
    mass_ = n.has("mass") ? n.number("mass") : density * solid_.unit.mass;
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    RigidModel model;
    model.shape = solid_.shape;
    model.center_of_mass = solid_.unit.center;
    model.mass = mass_;
    model.volume = solid_.unit.volume;
    model.inertia = mass_ / solid_.unit.mass * solid_.unit.inertia;
    model.position = place.position;
    model.rotation = place.rotation;
    model.velocity = place.velocity;
    model.angular_velocity = place.angular_velocity;
    model.part.voxel_size = solid_.voxel_size;
    // Six times volume over area is a box's column and a ball's diameter.
    model.part.areal_mass = 6.0 * mass_ / solid_.area;
    model.part.thickness = solid_.shape->thickness();
    model.part.width = width_of(solid_.unit.volume, model.part.thickness, solid_.shape->bounds());
    model.part.material = material_;
    model.surface = solid_.surface;
    return std::make_unique<RigidBody>(std::move(model));
  }

 private:
  Solid solid_;
  Material material_;
  double mass_;
};

}  // namespace

BodyKind rigid_kind() {
  return {"rigid", check_rigid, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<RigidMaker>(n, c);
          }};
}

}  // namespace brim
