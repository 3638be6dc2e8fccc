#include "brim/map/lever_weights.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {
constexpr std::size_t kLeverGrain = 512;
}

void LeverWeightsMap::reset(std::size_t particles, std::size_t points, int entries_per_point) {
  std::vector<std::int32_t> row_start(points + 1);
  for (std::size_t p = 0; p <= points; ++p) row_start[p] = static_cast<std::int32_t>(entries_per_point * p);
  reset(particles, std::move(row_start));
}

void LeverWeightsMap::reset(std::size_t particles, std::vector<std::int32_t> row_start) {
  particles_ = particles;
  row_start_ = std::move(row_start);
  const auto entries = static_cast<std::size_t>(row_start_.back());
  particle_.assign(entries, 0);
  weight_.assign(entries, 0.0);
  lever_.assign(entries, Vec3::Zero());
  direction_.assign(row_start_.size() - 1, Vec3::Zero());
}

void LeverWeightsMap::finish() {
  transpose_.build(particles_, row_start_, particle_);
  share_.resize(transpose_.entries.size());
  for (std::size_t e = 0; e < share_.size(); ++e) {
    const auto& entry = transpose_.entries[e];
    share_[e] = {weight_[entry.index], lever_[entry.index], entry.row};
  }
}

void LeverWeightsMap::velocity(std::span<const double> v, std::span<Vec3> u) const {
  BRIM_CHECK(v.size(), ==, 3 * particles_);
  BRIM_CHECK(u.size(), ==, points());
  parallel_blocks(points(), kLeverGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      Vec3 sum = Vec3::Zero();
      for (std::int32_t e = row_start_[p]; e < row_start_[p + 1]; ++e) {
        const Eigen::Map<const Vec3> vi(v.data() + 3 * particle_[e]);
        sum += weight_[e] * vi + direction_[p].dot(vi) * lever_[e];
      }
      u[p] = sum;
    }
  });
}

void LeverWeightsMap::add_force(std::span<const Vec3> f, std::span<double> Q) const {
  BRIM_CHECK(Q.size(), ==, 3 * particles_);
  BRIM_CHECK(f.size(), ==, points());
  parallel_blocks(transpose_.columns.size(), kLeverGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Vec3 sum = Vec3::Zero();
      for (std::int32_t e = transpose_.first[c]; e < transpose_.first[c + 1]; ++e) {
        const Share& s = share_[e];
        sum += s.weight * f[s.row] + s.lever.dot(f[s.row]) * direction_[s.row];
      }
      Eigen::Map<Vec3>(Q.data() + 3 * transpose_.columns[c]) += sum;
    }
  });
}

bool LeverWeightsMap::append_rows(MapRows& out) const {
  for (std::size_t p = 0; p < points(); ++p) {
    for (std::int32_t e = row_start_[p]; e < row_start_[p + 1]; ++e)
      out.add(particle_[e], (weight_[e] * Mat3::Identity() + lever_[e] * direction_[p].transpose()).cast<float>());
    out.end_row();
  }
  return true;
}

void LeverWeightsMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  BRIM_CHECK(K.size(), ==, points());
  parallel_blocks(transpose_.columns.size(), kLeverGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Mat3 sum = Mat3::Zero();
      for (const auto& e : transpose_.of(c)) {
        const Mat3 J = weight_[e.index] * Mat3::Identity() + lever_[e.index] * direction_[e.row].transpose();
        sum += J.transpose() * K[e.row] * J;
      }
      D.block(first + transpose_.columns[c]) += sum;
    }
  });
}

}  // namespace brim
