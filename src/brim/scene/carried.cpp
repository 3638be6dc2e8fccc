#include "brim/scene/carried.h"

namespace brim {

ElasticOptions read_elastic(const Node& n, const Placement& place, const Material& material) {
  ElasticOptions options;
  options.density = n.has("density") ? n.number("density") : 1000.0;
  options.young = n.number("young_modulus");
  options.poisson = n.number("poisson_ratio");
  options.neo_hookean = n.string("law") == "neo_hookean";
  options.stiffness_damping = n.number("stiffness_damping");
  options.mass_damping = n.number("mass_damping");
  options.initial_velocity = place.velocity;
  options.initial_spin = place.angular_velocity;
  options.material = material;
  return options;
}

}  // namespace brim
