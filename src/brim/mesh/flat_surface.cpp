#include "brim/mesh/flat_surface.h"

#include <algorithm>
#include <cmath>

#include "brim/math/small_symmetric.h"

namespace brim {

bool is_flat(const TriMesh& mesh) {
  constexpr double kFlat = 1e-6;
  if (mesh.vertices.empty()) return true;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& x : mesh.vertices) mean += x / static_cast<double>(mesh.vertices.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& x : mesh.vertices) spread += (x - mean) * (x - mean).transpose();
  // The spread's own eigenvalues are squares, too rough for 1e-6; along its thinnest axis lengths are measured.
  const Vec3 normal = symmetric_axes(spread).vectors.col(0);
  double thickness = 0.0, size = 0.0;
  for (const Vec3& x : mesh.vertices) {
    thickness = std::max(thickness, std::abs(normal.dot(x - mean)));
    size = std::max(size, (x - mean).norm());
  }
  return thickness <= kFlat * size;
}

}  // namespace brim
