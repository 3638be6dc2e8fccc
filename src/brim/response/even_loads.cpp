#include "brim/response/even_loads.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "brim/response/moved_rows.h"

namespace brim {

namespace {

/// Smallest pivot of the normal equations, relative to their trace: below it the points lie on a line.
constexpr double kOnALine = 1e-6;

}  // namespace

bool even_loads(std::span<const Vec3> points, const Vec3& normal, std::span<double> load) {
  const std::size_t n = points.size();
  double sum = 0.0, size = 0.0;
  Vec3 center = Vec3::Zero();
  for (std::size_t i = 0; i < n; ++i) sum += load[i], center += load[i] * points[i];
  if (n < 4 || !(sum > 0.0)) return false;
  center /= sum;
  for (const Vec3& x : points) size = std::max(size, (x - center).norm());
  if (!(size > 0.0)) return false;
  const Eigen::Matrix<double, 3, 2> across = tangents_of(normal);
  std::vector<Vec3> at(n);  // 1 and the place from the centre of load
  for (std::size_t i = 0; i < n; ++i) at[i] << 1.0, across.transpose() * (points[i] - center) / size;
  // Points that would pull bear nothing, and the others share.
  std::vector<std::uint8_t> bears(n, 1);
  std::vector<double> even(n);
  for (std::size_t round = 0; round + 2 < n; ++round) {
    Mat3 A = Mat3::Zero();
    for (std::size_t i = 0; i < n; ++i)
      if (bears[i]) A += at[i] * at[i].transpose();
    const Eigen::LDLT<Mat3> solve(A);
    if (!(solve.vectorD().minCoeff() > kOnALine * A.trace())) return false;
    const Vec3 law = solve.solve(Vec3(sum, 0.0, 0.0));
    bool pulls = false;
    for (std::size_t i = 0; i < n; ++i) {
      even[i] = bears[i] ? law.dot(at[i]) : 0.0;
      if (even[i] < 0.0) bears[i] = 0, pulls = true;
    }
    if (pulls) continue;
    std::copy(even.begin(), even.end(), load.begin());
    return true;
  }
  return false;
}

}  // namespace brim
