#include "brim/body/particle_fluid/fluid_map.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {
constexpr std::size_t kGrain = 512;
}

void FluidMap::assign(std::size_t particles, std::span<const std::vector<Entry>> rows,
                      std::span<const std::int32_t> length, std::span<const Vec3> direction) {
  BRIM_CHECK(length.size(), ==, direction.size());
  particles_ = particles;
  direction_.assign(direction.begin(), direction.end());
  row_start_.assign(1, 0);
  for (const std::int32_t n : length) row_start_.push_back(row_start_.back() + n);
  entry_.clear();
  for (const auto& list : rows) entry_.insert(entry_.end(), list.begin(), list.end());
  BRIM_CHECK(entry_.size(), ==, static_cast<std::size_t>(row_start_.back()));
  by_particle_.made = false;
}

bool FluidMap::select(std::span<const std::uint32_t> rows, std::unique_ptr<Map>& out) const {
  auto* map = dynamic_cast<FluidMap*>(out.get());
  if (map == nullptr) {
    auto made = std::make_unique<FluidMap>();
    map = made.get();
    out = std::move(made);
  }
  map->particles_ = particles_;
  map->row_start_.assign(1, 0);
  map->direction_.resize(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    map->direction_[i] = direction_[rows[i]];
    map->row_start_.push_back(map->row_start_.back() + row_start_[rows[i] + 1] - row_start_[rows[i]]);
  }
  map->entry_.resize(static_cast<std::size_t>(map->row_start_.back()));
  parallel_blocks(rows.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      std::copy(entry_.begin() + row_start_[rows[i]], entry_.begin() + row_start_[rows[i] + 1],
                map->entry_.begin() + map->row_start_[i]);
  });
  map->by_particle_.made = false;
  return true;
}

const FluidMap::ByParticle& FluidMap::by_particle() const {
  ByParticle& b = by_particle_;
  if (b.made) return b;
  const std::lock_guard lock(b.making);
  if (b.made) return b;
  b.column.resize(entry_.size()), b.entry.resize(entry_.size());
  for (std::size_t i = 0; i < entry_.size(); ++i) b.column[i] = entry_[i].particle;
  b.transpose.build(particles_, row_start_, b.column);
  parallel_blocks(entry_.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const RowTranspose::Entry& t = b.transpose.entries[i];
      b.entry[i] = {t.row, entry_[t.index].weight, entry_[t.index].slope};
    }
  });
  b.made = true;
  return b;
}

void FluidMap::velocity(std::span<const double> v, std::span<Vec3> u) const {
  BRIM_CHECK(v.size(), ==, 3 * particles_);
  BRIM_CHECK(u.size(), ==, points());
  parallel_blocks(points(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      Vec3 sum = Vec3::Zero();
      double along = 0.0;
      for (std::int32_t i = row_start_[p]; i < row_start_[p + 1]; ++i) {
        const Entry& e = entry_[i];
        const Eigen::Map<const Vec3> vp(v.data() + 3 * e.particle);
        sum += e.weight * vp;
        along += e.slope.dot(vp);
      }
      u[p] = sum + (along - direction_[p].dot(sum)) * direction_[p];
    }
  });
}

void FluidMap::add_force(std::span<const Vec3> f, std::span<double> Q) const {
  BRIM_CHECK(Q.size(), ==, 3 * particles_);
  BRIM_CHECK(f.size(), ==, points());
  const ByParticle& by = by_particle();
  parallel_blocks(by.transpose.columns.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Vec3 sum = Vec3::Zero();
      for (std::int32_t i = by.transpose.first[c]; i < by.transpose.first[c + 1]; ++i) {
        const Entry& e = by.entry[i];
        const Vec3 &force = f[e.particle], &u = direction_[e.particle];
        const double normal = u.dot(force);
        sum += e.weight * (force - normal * u) + normal * e.slope;
      }
      Eigen::Map<Vec3>(Q.data() + 3 * by.transpose.columns[c]) += sum;
    }
  });
}

void FluidMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  BRIM_CHECK(K.size(), ==, points());
  const ByParticle& by = by_particle();
  parallel_blocks(by.transpose.columns.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      Mat3 sum = Mat3::Zero();
      for (std::int32_t i = by.transpose.first[c]; i < by.transpose.first[c + 1]; ++i) {
        const Entry& e = by.entry[i];
        const Vec3& u = direction_[e.particle];
        const double w = e.weight;
        const Mat3 J = u * (e.slope - w * u).transpose() + w * Mat3::Identity();
        sum += J.transpose() * K[e.particle] * J;
      }
      D.block(first + by.transpose.columns[c]) += sum;
    }
  });
}

}  // namespace brim
