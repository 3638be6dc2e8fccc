#include "brim/map/shell_weights.h"

#include <algorithm>
#include <limits>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

constexpr std::size_t kGrain = 512;

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

}  // namespace

void ShellWeightsMap::reset(std::size_t particles, std::size_t points) {
  particles_ = particles;
  row_start_.resize(points + 1);
  for (std::size_t p = 0; p <= points; ++p) row_start_[p] = static_cast<std::int32_t>(3 * p);
  particle_.assign(3 * points, 0);
  weight_.assign(3 * points, 0.0);
  lever_.assign(3 * points, Vec3::Zero());
  normal_.assign(points, Vec3::Zero());
}

void ShellWeightsMap::set(std::size_t p, const Vec3& r, const std::array<std::int32_t, 3>& triangle,
                          std::span<const Vec3> x) {
  const std::array<Vec3, 3> c = {x[triangle[0]], x[triangle[1]], x[triangle[2]]};
  const Vec3 m = (c[1] - c[0]).cross(c[2] - c[0]);
  const double m2 = m.squaredNorm();
  const Vec3 n = m2 > 0.0 ? Vec3(m / std::sqrt(m2)) : Vec3::UnitZ();
  Vec3 b = Vec3::Constant(std::numeric_limits<double>::infinity());
  std::array<Vec3, 3> gradient;
  if (m2 > 0.0) {
    // ∇b_i = n × (edge opposite to i) / (2 area).
    for (int i = 0; i < 3; ++i) {
      gradient[i] = m.cross(c[(i + 2) % 3] - c[(i + 1) % 3]) / m2;
      b[i] = gradient[i].dot(r - c[(i + 1) % 3]);
    }
    b[0] = 1.0 - b[1] - b[2];
  }
  double d = n.dot(r - c[0]);
  if (!(b.cwiseAbs().sum() <= kMaxWeight)) {
    b = clamped_to_edges(r, c);
    d = 0.0;
    gradient.fill(Vec3::Zero());
  }
  normal_[p] = n;
  for (int i = 0; i < 3; ++i) {
    particle_[3 * p + i] = triangle[i];
    weight_[3 * p + i] = b[i];
    lever_[3 * p + i] = -d * gradient[i];
  }
}

void ShellWeightsMap::finish() { transpose_.build(particles_, row_start_, particle_); }

void ShellWeightsMap::velocity(std::span<const double> v, std::span<Vec3> u) const {
  BRIM_CHECK(v.size(), ==, 3 * particles_);
  BRIM_CHECK(u.size(), ==, points());
  parallel_blocks(points(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      Vec3 sum = Vec3::Zero();
      for (std::size_t e = 3 * p; e < 3 * p + 3; ++e) {
        const Eigen::Map<const Vec3> vi(v.data() + 3 * particle_[e]);
        sum += weight_[e] * vi + normal_[p].dot(vi) * lever_[e];
      }
      u[p] = sum;
    }
  });
}

void ShellWeightsMap::add_force(std::span<const Vec3> f, std::span<double> Q) const {
  BRIM_CHECK(Q.size(), ==, 3 * particles_);
  BRIM_CHECK(f.size(), ==, points());
  parallel_blocks(transpose_.columns.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Vec3 sum = Vec3::Zero();
      for (const auto& e : transpose_.of(c))
        sum += weight_[e.index] * f[e.row] + lever_[e.index].dot(f[e.row]) * normal_[e.row];
      Eigen::Map<Vec3>(Q.data() + 3 * transpose_.columns[c]) += sum;
    }
  });
}

void ShellWeightsMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  BRIM_CHECK(K.size(), ==, points());
  parallel_blocks(transpose_.columns.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Mat3 sum = Mat3::Zero();
      for (const auto& e : transpose_.of(c)) {
        const Mat3 J = weight_[e.index] * Mat3::Identity() + lever_[e.index] * normal_[e.row].transpose();
        sum += J.transpose() * K[e.row] * J;
      }
      D.block(first + transpose_.columns[c]) += sum;
    }
  });
}

}  // namespace brim
