#include "brim/mesh/lattice_around.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "brim/core/error.h"
#include "brim/mesh/bcc_lattice.h"

namespace brim {

HeldPoints lattice_around(std::span<const Vec3> points, double spacing, double cube,
                          std::span<const std::uint8_t> whole, std::size_t max_tets) {
  if (points.empty()) throw InputError("lattice: there are no points to hold");
  if (!(spacing > 0.0) || !std::isfinite(spacing))
    throw InputError(fmt::format("lattice: a spacing of {} m is not allowed; must be positive and finite", spacing));
  Aabb box;
  for (const Vec3& p : points) box.extend(p);
  const double most = 12.0 * ((box.extent() / spacing).array() + 4.0).prod();
  if (!(most <= static_cast<double>(max_tets)))
    throw InputError(fmt::format("lattice: a spacing of {:.3g} m would make {:.3g} tetrahedra; {} are allowed", spacing,
                                 most, max_tets));
  const BccLattice lattice(box, spacing);
  std::vector<std::int64_t> place(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) place[i] = lattice.tet_at(points[i]);
  std::vector<std::int64_t> wanted = place;
  BRIM_CHECK((whole.empty() || whole.size() == points.size()), ==, true);
  // Samples a fifth of the spacing apart leave no ball empty that is as large as a tetrahedron's inner one (radius
  // 0.177 spacings): none is missed.
  const int n = std::max(1, static_cast<int>(std::ceil(5.0 * cube / spacing)));
  const auto sample = [&](std::size_t i, int c) {
    const Vec3 at = Vec3(c % n, c / n % n, c / (n * n)) + Vec3::Constant(0.5 - 0.5 * n);
    return lattice.tet_at(points[i] + cube / n * at);
  };
  for (std::size_t i = 0; i < whole.size(); ++i)
    if (whole[i] != 0)
      for (int c = 0; c < n * n * n; ++c) wanted.push_back(sample(i, c));
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());

  HeldPoints held;
  std::vector<std::int32_t> number(static_cast<std::size_t>(lattice.node_count()), -1);
  std::int64_t at = 0;
  std::size_t next = 0;
  lattice.for_each_tet([&](Tetrahedron t) {
    if (next < wanted.size() && wanted[next] == at++) {
      ++next;
      for (std::int32_t& corner : t) {
        std::int32_t& vertex = number[static_cast<std::size_t>(corner)];
        if (vertex < 0) {
          vertex = static_cast<std::int32_t>(held.mesh.vertices.size());
          held.mesh.vertices.push_back(lattice.position(corner));
        }
        corner = vertex;
      }
      held.mesh.tets.push_back(t);
    }
  });
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto e = static_cast<std::int32_t>(std::lower_bound(wanted.begin(), wanted.end(), place[i]) - wanted.begin());
    const Tetrahedron& t = held.mesh.tets[static_cast<std::size_t>(e)];
    const Vec3 x0 = held.mesh.vertices[t[0]];
    Mat3 sides;
    for (int k = 0; k < 3; ++k) sides.col(k) = held.mesh.vertices[t[k + 1]] - x0;
    const Vec3 b = sides.inverse() * (points[i] - x0);
    held.embedding.tet.push_back(e);
    held.embedding.weights.push_back({1.0 - b.sum(), b[0], b[1], b[2]});
    int missed = 0;
    for (int c = 0; c < n * n * n && (whole.empty() || whole[i] == 0); ++c)
      missed += !std::binary_search(wanted.begin(), wanted.end(), sample(i, c));
    held.outside.push_back(static_cast<double>(missed) / (n * n * n));
  }
  return held;
}

}  // namespace brim
