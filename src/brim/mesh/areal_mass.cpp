#include "brim/mesh/areal_mass.h"

#include <algorithm>

namespace brim {

double areal_mass(double mass, double volume, double surface, const Aabb& box, double h) {
  const Vec3 e = box.extent();
  const double outline = 2.0 * (e.x() * e.y() + e.y() * e.z() + e.z() * e.x());
  const double solid = 6.0 * mass / surface, wires = 6.0 * mass / volume * e.prod() / outline;
  const double thickness = 6.0 * volume / surface;
  return solid + std::clamp(2.0 - thickness / (3.0 * h), 0.0, 1.0) * std::max(wires - solid, 0.0);
}

}  // namespace brim
