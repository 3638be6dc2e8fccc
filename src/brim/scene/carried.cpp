#include "brim/scene/carried.h"

#include "brim/scene/particle_options.h"

namespace brim {

ElasticOptions read_elastic(const Node& n, const Placement& place, const Material& material) {
  ElasticOptions options;
  // A table by intensity is read with the image.
  const auto number = [&](const char* key, double otherwise) {
    return n.has(key) && n.at(key).json().is_number() ? n.number(key) : otherwise;
  };
  options.density = number("density", options.density);
  options.young = number("young_modulus", options.young);
  options.poisson = n.number("poisson_ratio");
  options.neo_hookean = n.string("law") == "neo_hookean";
  read_particle_options(n, place, material, options);
  return options;
}

}  // namespace brim
