#pragma once

#include "brim/body/particles/particle_body.h"
#include "brim/scene/node.h"
#include "brim/scene/placement.h"

namespace brim {

/// Reads the keys shared by bodies of particles; without constraints and self-contact, which not all have.
inline void read_particle_options(const Node& body, const Placement& place, const Material& material,
                                  ParticleOptions& options) {
  options.stiffness_damping = body.number("stiffness_damping");
  options.mass_damping = body.number("mass_damping");
  options.initial_velocity = place.velocity;
  options.initial_spin = place.angular_velocity;
  options.voxel_size = body.number("voxel_size");
  options.material = material;
}

}  // namespace brim
