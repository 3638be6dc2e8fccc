#include "brim/map/point_weights.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/map/picked_rows.h"
#include "brim/map/reuse_map.h"

namespace brim {

namespace {
constexpr std::size_t kPointGrain = 512;
}

void PointWeightsMap::reset(std::size_t particles, std::size_t points, int entries_per_point) {
  particles_ = particles;
  row_start_.resize(points + 1);
  for (std::size_t p = 0; p <= points; ++p) row_start_[p] = static_cast<std::int32_t>(p) * entries_per_point;
  particle_.assign(points * entries_per_point, 0);
  weight_.assign(points * entries_per_point, 0.0);
}

PointWeightsMap::Row PointWeightsMap::row(std::size_t point) {
  const std::size_t begin = row_start_[point], n = row_start_[point + 1] - begin;
  return {std::span(particle_).subspan(begin, n), std::span(weight_).subspan(begin, n)};
}

void PointWeightsMap::assign(std::size_t particles, std::span<const std::int32_t> row_start,
                             std::span<const std::int32_t> particle, std::span<const double> weight) {
  BRIM_CHECK(particle.size(), ==, weight.size());
  BRIM_CHECK(row_start.size(), >, 0u);
  BRIM_CHECK(static_cast<std::size_t>(row_start.back()), ==, weight.size());
  particles_ = particles;
  row_start_.assign(row_start.begin(), row_start.end());
  particle_.assign(particle.begin(), particle.end());
  weight_.assign(weight.begin(), weight.end());
  finish();
}

void PointWeightsMap::finish() { by_particle_.forget(); }

const RowShares<PointWeightsMap::Share>& PointWeightsMap::by_particle() const {
  by_particle_.make(particles_, row_start_, particle_, [&](std::int32_t row, std::int32_t index) {
    return Share{weight_[index], row};
  });
  return by_particle_;
}

void PointWeightsMap::apply(std::span<const double> v, std::span<Vec3> u) const {
  BRIM_CHECK(v.size(), ==, 3 * particles_);
  BRIM_CHECK(u.size(), ==, points());
  parallel_blocks(points(), kPointGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      Vec3 sum = Vec3::Zero();
      for (std::int32_t e = row_start_[p]; e < row_start_[p + 1]; ++e)
        sum += weight_[e] * Eigen::Map<const Vec3>(v.data() + 3 * particle_[e]);
      u[p] = sum;
    }
  });
}

void PointWeightsMap::apply_transpose(std::span<const Vec3> f, std::span<double> Q) const {
  BRIM_CHECK(Q.size(), ==, 3 * particles_);
  BRIM_CHECK(f.size(), ==, points());
  const RowShares<Share>& shares = by_particle();
  const auto& columns = shares.transpose.columns;
  parallel_blocks(columns.size(), kPointGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Vec3 sum = Vec3::Zero();
      for (const Share& s : shares.of(c)) sum += s.weight * f[s.row];
      Eigen::Map<Vec3>(Q.data() + 3 * columns[c]) += sum;
    }
  });
}

bool PointWeightsMap::select(std::span<const std::uint32_t> rows, std::unique_ptr<Map>& out) const {
  auto& map = reuse_map<PointWeightsMap>(out);
  map.particles_ = particles_;
  pick_row_starts(row_start_, rows, map.row_start_);
  map.particle_.resize(static_cast<std::size_t>(map.row_start_.back())), map.weight_.resize(map.particle_.size());
  parallel_blocks(rows.size(), kPointGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::int32_t to = map.row_start_[i];
      for (std::int32_t e = row_start_[rows[i]]; e < row_start_[rows[i] + 1]; ++e, ++to)
        map.particle_[to] = particle_[e], map.weight_[to] = weight_[e];
    }
  });
  map.finish();
  return true;
}

bool PointWeightsMap::append_rows(MapRows& out) const {
  for (std::size_t p = 0; p < points(); ++p) {
    for (std::int32_t e = row_start_[p]; e < row_start_[p + 1]; ++e)
      if (weight_[e] != 0.0) out.add(particle_[e], static_cast<float>(weight_[e]));
    out.end_row();
  }
  return true;
}

void PointWeightsMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  BRIM_CHECK(K.size(), ==, points());
  const RowShares<Share>& shares = by_particle();
  const auto& columns = shares.transpose.columns;
  parallel_blocks(columns.size(), kPointGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Mat3 sum = Mat3::Zero();
      const std::span<const Share> entries = shares.of(c);
      for (std::size_t i = 0; i < entries.size();) {
        // A row may name a particle twice; its weights add up before they are squared.
        const std::int32_t row = entries[i].row;
        double w = 0.0;
        for (; i < entries.size() && entries[i].row == row; ++i) w += entries[i].weight;
        sum += w * w * K[row];
      }
      D.block(first + columns[c]) += sum;
    }
  });
}

}  // namespace brim
