#include "brim/body/stressed_solid.h"

#include <Eigen/LU>
#include <cmath>

#include "brim/core/error.h"

namespace brim {

Mat3 cauchy_stress(const Mat3& P, const Mat3& F) {
  const double volume = std::abs(F.determinant());
  if (!(volume > 0.0)) return Mat3::Zero();
  const Mat3 s = P * F.transpose() / volume;
  return 0.5 * (s + s.transpose());
}

double von_mises(const Mat3& stress) {
  const Mat3 deviator = stress - stress.trace() / 3.0 * Mat3::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

Mat3 green_strain(const Mat3& F) { return 0.5 * (F.transpose() * F - Mat3::Identity()); }

std::vector<double> node_means(std::size_t nodes, std::span<const Tetrahedron> tets, std::span<const double> volume,
                               std::span<const double> filled, std::span<const double> value) {
  BRIM_CHECK(value.size(), ==, tets.size());
  std::vector<double> sum(nodes, 0.0), matter(nodes, 0.0);
  for (std::size_t e = 0; e < tets.size(); ++e)
    for (const std::int32_t n : tets[e]) {
      sum[static_cast<std::size_t>(n)] += volume[e] * value[e];
      matter[static_cast<std::size_t>(n)] += volume[e] * (filled.empty() ? 1.0 : filled[e]);
    }
  for (std::size_t n = 0; n < nodes; ++n) sum[n] = matter[n] > 0.0 ? sum[n] / matter[n] : 0.0;
  return sum;
}

}  // namespace brim
