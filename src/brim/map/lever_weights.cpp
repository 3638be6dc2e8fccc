#include "brim/map/lever_weights.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/map/picked_rows.h"
#include "brim/map/reuse_map.h"

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

void LeverWeightsMap::finish() { by_particle_.forget(); }

const RowShares<LeverWeightsMap::Share>& LeverWeightsMap::by_particle() const {
  by_particle_.make(particles_, row_start_, particle_, [&](std::int32_t row, std::int32_t index) {
    return Share{weight_[index], lever_[index], row};
  });
  return by_particle_;
}

bool LeverWeightsMap::select(std::span<const std::uint32_t> rows, std::unique_ptr<Map>& out) const {
  auto& map = reuse_map<LeverWeightsMap>(out);
  map.particles_ = particles_;
  pick_row_starts(row_start_, rows, map.row_start_);
  const auto entries = static_cast<std::size_t>(map.row_start_.back());
  map.particle_.resize(entries), map.weight_.resize(entries), map.lever_.resize(entries);
  map.direction_.resize(rows.size());
  parallel_blocks(rows.size(), kLeverGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      map.direction_[i] = direction_[rows[i]];
      std::int32_t to = map.row_start_[i];
      for (std::int32_t e = row_start_[rows[i]]; e < row_start_[rows[i] + 1]; ++e, ++to)
        map.particle_[to] = particle_[e], map.weight_[to] = weight_[e], map.lever_[to] = lever_[e];
    }
  });
  map.finish();
  return true;
}

void LeverWeightsMap::apply(std::span<const double> v, std::span<Vec3> u) const {
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

void LeverWeightsMap::apply_transpose(std::span<const Vec3> f, std::span<double> Q) const {
  BRIM_CHECK(Q.size(), ==, 3 * particles_);
  BRIM_CHECK(f.size(), ==, points());
  const RowShares<Share>& shares = by_particle();
  const auto& columns = shares.transpose.columns;
  parallel_blocks(columns.size(), kLeverGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Vec3 sum = Vec3::Zero();
      for (const Share& s : shares.of(c)) sum += s.weight * f[s.row] + s.lever.dot(f[s.row]) * direction_[s.row];
      Eigen::Map<Vec3>(Q.data() + 3 * columns[c]) += sum;
    }
  });
}

bool LeverWeightsMap::append_rows(MapRows& out) const {
  for (std::size_t p = 0; p < points(); ++p) {
    for (std::int32_t e = row_start_[p]; e < row_start_[p + 1]; ++e)
      out.add(particle_[e],
              Eigen::Matrix3f((weight_[e] * Mat3::Identity() + lever_[e] * direction_[p].transpose()).cast<float>()));
    out.end_row();
  }
  return true;
}

void LeverWeightsMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  BRIM_CHECK(K.size(), ==, points());
  const RowShares<Share>& shares = by_particle();
  const auto& columns = shares.transpose.columns;
  parallel_blocks(columns.size(), kLeverGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Mat3 sum = Mat3::Zero();
      for (const Share& s : shares.of(c)) {
        const Mat3 J = s.weight * Mat3::Identity() + s.lever * direction_[s.row].transpose();
        sum += J.transpose() * K[s.row] * J;
      }
      D.block(first + columns[c]) += sum;
    }
  });
}

}  // namespace brim
