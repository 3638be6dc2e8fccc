#include <algorithm>

#include "brim/body/particle_fluid/particle_fluid_body.h"
#include "brim/mesh/topology.h"
#include "brim/scene/kinds.h"
#include "brim/scene/limits.h"
#include "brim/scene/region.h"
#include "brim/scene/repeat.h"
#include "brim/scene/solid.h"

namespace brim {

BodyKind particle_fluid_kind();

namespace {

/// [bytes] that a particle with its neighbours, solver blocks and state takes.
constexpr double kBytesPerFluidParticle = 2000.0;

void check_particle_fluid(const Node& n) {
  refuse_plane(n.at("shape"), "volume");
  check_shape(n.at("shape"));
  check_regions(n.at("carve"));
  const double spacing = n.at("transform").number("scale") * n.number("spacing");
  if (n.number("voxel_size") > spacing * (1.0 + 1e-9))
    throw n.at("voxel_size")
        .error(fmt::format("{} is not allowed; must be at most the spacing, {:.6g} m: the fluid would leak",
                           n.number("voxel_size"), spacing));
}

class ParticleFluidMaker final : public BodyMaker {
 public:
  ParticleFluidMaker(const Node& n, const BuildContext& context)
      : node_(n), material_(context.material), gravity_(context.world.environment.gravity) {
    const double scale = n.at("transform").number("scale"), limit = context.world.memory_limit;
    spacing_ = scale * n.number("spacing");
    if (context.world.voxel_size > spacing_ * (1.0 + 1e-9))
      throw n.at("spacing").error(fmt::format(
          "{:.6g} m is not allowed; must be at least the world's voxel_size, {:.6g} m: the fluid would leak", spacing_,
          context.world.voxel_size));
    const Solid solid = read_solid(n, limit, context.solids);
    const Aabb box = bounds(solid.surface->vertices);
    const Node at = n.at("spacing");
    if (spacing_ > box.extent().minCoeff())
      throw at.error(fmt::format("{:.6g} m is not allowed; must be at most the shape's smallest extent, {:.6g} m",
                                 spacing_, box.extent().minCoeff()));
    check_count(at, box.extent().prod() / (spacing_ * spacing_ * spacing_), kBytesPerFluidParticle, limit, "particles");
    const FluidLattice lattice =
        lattice_in_solid([&](const Vec3& x) { return solid.shape->distance(x); }, box, solid.unit.mass, spacing_);
    const RegionDistance carved = region_distance(n.at("carve"));
    SceneRandom random(static_cast<std::uint64_t>(n.integer("seed")));
    const double jitter = spacing_ * n.number("jitter");
    for (const Vec3& x : lattice.x) {
      if (carved(x / scale) < 0.0) continue;
      Vec3 moved = x;
      for (double& along : moved) along += jitter * random.symmetric();
      particles_.push_back(moved);
    }
    if (particles_.empty())
      throw at.error(
          fmt::format("no particle fits: {:.6g} m is too large for what \"carve\" leaves of the shape", spacing_));
    spacing_ = lattice.spacing;
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    std::vector<Vec3> x = particles_;
    for (Vec3& p : x) p = place.position + place.rotation * p;
    ParticleFluidOptions options;
    options.spacing = spacing_;
    options.density = node_.number("density");
    options.viscosity = node_.number("viscosity");
    options.surface_tension = node_.number("surface_tension");
    options.bulk_modulus = node_.number("bulk_modulus");
    options.compression = node_.number("compression");
    options.gravity = gravity_;
    options.initial_velocity = place.velocity;
    options.initial_spin = place.angular_velocity;
    options.voxel_size = std::min(node_.number("voxel_size"), spacing_);
    options.material = material_;
    return std::make_unique<ParticleFluidBody>(std::move(x), std::move(options));
  }

 private:
  Node node_;
  Material material_;
  Vec3 gravity_;
  double spacing_ = 0.0;         ///< [m] of the lattice that fits the shape
  std::vector<Vec3> particles_;  ///< scaled, not placed
};

}  // namespace

BodyKind particle_fluid_kind() {
  return {"particle_fluid", check_particle_fluid,
          [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<ParticleFluidMaker>(n, c);
          }};
}

}  // namespace brim
