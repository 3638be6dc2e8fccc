#include "brim/map/shell_weights.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "brim/core/parallel.h"
#include "brim/math/small_symmetric.h"

namespace brim {

namespace {

constexpr std::size_t kGrain = 512;

using PlaneWeights = ShellWeightsMap::PlaneWeights;

/// Barycentric weights of the point of a triangle that is closest to the point with plane weights b outside of it:
/// the best of the three edges.
Vec3 clamped_to_edges(const Vec3& r, const std::array<Vec3, 3>& x) {
  Vec3 best = Vec3::Zero();
  double best_distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const Vec3 e = x[j] - x[i];
    const double length2 = e.squaredNorm();
    const double t = length2 > 0.0 ? std::clamp((r - x[i]).dot(e) / length2, 0.0, 1.0) : 0.0;
    const double distance = (x[i] + t * e - r).squaredNorm();
    if (distance < best_distance) {
      best_distance = distance;
      best.setZero();
      best[i] = 1.0 - t;
      best[j] = t;
    }
  }
  return best;
}

PlaneWeights plane_weights(const Vec3& r, const std::array<Vec3, 3>& c) {
  PlaneWeights w;
  const Vec3 m = (c[1] - c[0]).cross(c[2] - c[0]);
  const double m2 = m.squaredNorm();
  w.has_area = m2 > 0.0;
  if (!w.has_area) return w;
  w.n = m / std::sqrt(m2);
  // ∇b_i = n × (edge opposite to i) / (2 area).
  for (int i = 0; i < 3; ++i) {
    w.gradient[i] = m.cross(c[(i + 2) % 3] - c[(i + 1) % 3]) / m2;
    w.b[i] = w.gradient[i].dot(r - c[(i + 1) % 3]);
  }
  w.b[0] = 1.0 - w.b[1] - w.b[2];
  return w;
}

std::array<Vec3, 3> corners(const SheetPatches::Corners& triangle, std::span<const Vec3> x) {
  return {x[triangle[0]], x[triangle[1]], x[triangle[2]]};
}

double lever_of(const PlaneWeights& w, double d) {
  double most = 0.0;
  for (int i = 0; i < 3; ++i) most = std::max(most, std::abs(w.b[i]) + std::abs(d) * w.gradient[i].norm());
  return most;
}

}  // namespace

double ShellWeightsMap::lever(const Vec3& r, const SheetPatches::Corners& triangle, std::span<const Vec3> x) {
  const std::array<Vec3, 3> c = corners(triangle, x);
  const PlaneWeights w = plane_weights(r, c);
  return w.has_area ? lever_of(w, w.n.dot(r - c[0])) : std::numeric_limits<double>::infinity();
}

void ShellWeightsMap::build(const SheetPatches& sheet, std::span<const Vec3> points,
                            std::span<const std::int32_t> triangle, std::span<const Vec3> x) {
  // Most points ride on their triangle: it is measured once.
  struct Ride {
    PlaneWeights weights;
    double offset;
    bool carried;
  };
  std::vector<Ride> rides(points.size());
  std::vector<std::int32_t> row_start(points.size() + 1, 0);
  parallel_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const std::array<Vec3, 3> c = corners(sheet.triangle(triangle[p]), x);
      Ride& ride = rides[p];
      ride.weights = plane_weights(points[p], c);
      ride.offset = ride.weights.has_area ? ride.weights.n.dot(points[p] - c[0]) : 0.0;
      ride.carried = ride.weights.has_area && lever_of(ride.weights, ride.offset) <= kMaxLever;
      row_start[p + 1] = ride.carried ? 3 : static_cast<std::int32_t>(sheet.around(triangle[p]).size());
    }
  });
  std::partial_sum(row_start.begin(), row_start.end(), row_start.begin());
  reset(x.size(), std::move(row_start));
  parallel_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const SheetPatches::Corners& own = sheet.triangle(triangle[p]);
      if (rides[p].carried)
        ride_on_triangle(p, own, rides[p].weights, rides[p].offset);
      else if (!ride_on_patch(p, points[p], sheet.around(triangle[p]), x))
        ride_on_closest(p, points[p], own, x);
    }
  });
  finish();
}

void ShellWeightsMap::ride_on_triangle(std::size_t p, const SheetPatches::Corners& triangle, const PlaneWeights& w,
                                       double d) {
  direction_[p] = w.n;
  for (std::int32_t i = 0, e = row_start_[p]; i < 3; ++i, ++e) {
    particle_[e] = triangle[i];
    weight_[e] = w.b[i];
    lever_[e] = -d * w.gradient[i];
  }
}

bool ShellWeightsMap::ride_on_patch(std::size_t p, const Vec3& r, std::span<const std::int32_t> patch,
                                    std::span<const Vec3> x) {
  const auto k = static_cast<double>(patch.size());
  Vec3 c = Vec3::Zero();
  for (const std::int32_t i : patch) c += x[i];
  c /= k;
  Mat3 spread = Mat3::Zero();
  for (const std::int32_t i : patch) spread += (x[i] - c) * (x[i] - c).transpose();
  const SymmetricAxes axes = symmetric_axes(spread);
  const Vec3 n = axes.vectors.col(0);
  const Vec3& share = axes.values;  // ascending
  if (!(share[1] > 1e-12 * share[2])) return false;
  const auto across = axes.vectors.rightCols<2>();
  const Mat3 inverse = across * share.tail<2>().cwiseInverse().asDiagonal() * across.transpose();

  Vec3 foot = Vec3::Zero();
  for (std::size_t i = 0; i < patch.size(); ++i) {
    const std::int32_t e = row_start_[p] + static_cast<std::int32_t>(i);
    particle_[e] = patch[i];
    lever_[e] = inverse * (x[patch[i]] - c);
    weight_[e] = 1.0 / k + lever_[e].dot(r - c);
    foot += weight_[e] * x[patch[i]];
  }
  const double d = n.dot(r - foot);
  direction_[p] = n;
  double most = 0.0;
  for (std::int32_t e = row_start_[p]; e < row_start_[p + 1]; ++e) {
    lever_[e] *= -d;
    most = std::max(most, std::abs(weight_[e]) + lever_[e].norm());
  }
  return most <= 3.0 * kMaxLever;
}

void ShellWeightsMap::ride_on_closest(std::size_t p, const Vec3& r, const SheetPatches::Corners& triangle,
                                      std::span<const Vec3> x) {
  const Vec3 b = clamped_to_edges(r, corners(triangle, x));
  direction_[p].setZero();
  for (std::int32_t e = row_start_[p]; e < row_start_[p + 1]; ++e) {
    const auto corner = std::find(triangle.begin(), triangle.end(), particle_[e]);
    weight_[e] = corner == triangle.end() ? 0.0 : b[corner - triangle.begin()];
    lever_[e].setZero();
  }
}

}  // namespace brim
