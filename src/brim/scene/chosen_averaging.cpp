#include "brim/scene/chosen_averaging.h"

#include <algorithm>
#include <cmath>

#include "brim/mesh/mass_properties.h"
#include "brim/mesh/topology.h"

namespace brim {

namespace {

/// [-] The longest side over the thickness of a solid that is slender.
constexpr double kSlender = 4.0;

}  // namespace

double SolidSize::thickness() const {
  Vec3 side = extent;
  std::sort(side.begin(), side.end());
  const double third = 1.0 / std::max(0.5 * area / volume - 1.0 / side[1] - 1.0 / side[2], 1.0 / side[2]);
  return std::max(third, std::min(4.0 * volume / area, side[0]));
}

SolidSize size_of(const TetMesh& mesh) {
  Aabb box;
  for (const Vec3& x : mesh.vertices) box.extend(x);
  double volume = 0.0;
  for (const auto& [a, b, c, d] : mesh.tets)
    volume += std::abs(tet_volume(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], mesh.vertices[d]));
  const double element = std::cbrt(6.0 * std::sqrt(2.0) * volume / static_cast<double>(mesh.tets.size()));
  return {volume, surface_area({mesh.vertices, tet_surface(mesh).triangles}), box.extent(), element};
}

double chosen_averaging(const Node& body, const SolidSize& size, double enough, double share) {
  if (body.has("averaging")) return body.number("averaging");
  const double thickness = size.thickness();
  return size.extent.maxCoeff() >= kSlender * thickness && thickness < enough * size.element ? share : 0.0;
}

}  // namespace brim
