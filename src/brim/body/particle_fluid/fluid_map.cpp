#include "brim/body/particle_fluid/fluid_map.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/map/reuse_map.h"

namespace brim {

namespace {
constexpr std::size_t kRowGrain = 512;
}

void FluidMap::assign(std::shared_ptr<const std::vector<Vec3>> x, std::vector<Row> rows,
                      std::span<const std::vector<Entry>> entries, std::span<const std::int32_t> length) {
  BRIM_CHECK(length.size(), ==, rows.size());
  x_ = std::move(x);
  row_ = std::move(rows);
  row_start_.assign(1, 0);
  for (const std::int32_t n : length) row_start_.push_back(row_start_.back() + n);
  entry_.clear();
  for (const auto& list : entries) entry_.insert(entry_.end(), list.begin(), list.end());
  BRIM_CHECK(entry_.size(), ==, static_cast<std::size_t>(row_start_.back()));
  by_particle_.made = false;
}

bool FluidMap::select(std::span<const std::uint32_t> rows, std::unique_ptr<Map>& out) const {
  auto& map = reuse_map<FluidMap>(out);
  map.x_ = x_;
  map.row_start_.assign(1, 0);
  map.row_.resize(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    map.row_[i] = row_[rows[i]];
    map.row_start_.push_back(map.row_start_.back() + row_start_[rows[i] + 1] - row_start_[rows[i]]);
  }
  map.entry_.resize(static_cast<std::size_t>(map.row_start_.back()));
  parallel_blocks(rows.size(), kRowGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      std::copy(entry_.begin() + row_start_[rows[i]], entry_.begin() + row_start_[rows[i] + 1],
                map.entry_.begin() + map.row_start_[i]);
  });
  map.by_particle_.made = false;
  return true;
}

const FluidMap::ByParticle& FluidMap::by_particle() const {
  ByParticle& b = by_particle_;
  if (b.made) return b;
  const std::lock_guard lock(b.making);
  if (b.made) return b;
  b.column.resize(entry_.size()), b.entry.resize(entry_.size());
  for (std::size_t i = 0; i < entry_.size(); ++i) b.column[i] = entry_[i].particle;
  b.transpose.build(x_->size(), row_start_, b.column);
  parallel_blocks(entry_.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const RowTranspose::Entry& t = b.transpose.entries[i];
      b.entry[i] = {t.row, entry_[t.index].value, entry_[t.index].slope};
    }
  });
  b.made = true;
  return b;
}

void FluidMap::apply(std::span<const double> v, std::span<Vec3> u) const {
  BRIM_CHECK(u.size(), ==, points());
  if (u.empty()) return;
  BRIM_CHECK(v.size(), ==, 3 * x_->size());
  const Vec3* x = x_->data();
  parallel_blocks(points(), kRowGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const Row& row = row_[p];
      Vec3 sum = Vec3::Zero();
      double along = 0.0;
      for (std::int32_t i = row_start_[p]; i < row_start_[p + 1]; ++i) {
        const Entry& e = entry_[i];
        const Eigen::Map<const Vec3> vp(v.data() + 3 * e.particle);
        sum += double(e.value) * vp;
        along += double(e.slope) * (row.node - x[e.particle]).dot(vp);
      }
      sum *= row.share;
      u[p] = sum + (row.steep * along + (row.rest - 1.0) * row.direction.dot(sum)) * row.direction;
    }
  });
}

void FluidMap::apply_transpose(std::span<const Vec3> f, std::span<double> Q) const {
  BRIM_CHECK(f.size(), ==, points());
  if (f.empty()) return;
  BRIM_CHECK(Q.size(), ==, 3 * x_->size());
  const ByParticle& by = by_particle();
  const Vec3* x = x_->data();
  auto push = pushes_.borrow();
  push->resize(points());
  parallel_blocks(points(), kRowGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const Row& row = row_[p];
      const double normal = row.direction.dot(f[p]);
      (*push)[p] = {row.share * (f[p] + ((row.rest - 1.0) * normal) * row.direction), row.node, row.steep * normal};
    }
  });
  parallel_blocks(by.transpose.columns.size(), kRowGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const std::int32_t particle = by.transpose.columns[c];
      const Vec3 at = x[particle];
      Vec3 sum = Vec3::Zero();
      for (std::int32_t i = by.transpose.first[c]; i < by.transpose.first[c + 1]; ++i) {
        const Entry& e = by.entry[i];
        const Push& row = (*push)[e.particle];
        sum += double(e.value) * row.even + (double(e.slope) * row.along) * (row.node - at);
      }
      Eigen::Map<Vec3>(Q.data() + 3 * particle) += sum;
    }
  });
}

void FluidMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  BRIM_CHECK(K.size(), ==, points());
  if (K.empty()) return;
  const ByParticle& by = by_particle();
  const Vec3* x = x_->data();
  parallel_blocks(by.transpose.columns.size(), kRowGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const std::int32_t particle = by.transpose.columns[c];
      Mat3 sum = Mat3::Zero();
      for (std::int32_t i = by.transpose.first[c]; i < by.transpose.first[c + 1]; ++i) {
        const Entry& e = by.entry[i];
        const Row& row = row_[e.particle];
        const double w = row.share * e.value;
        const Vec3 a = (row.steep * e.slope) * (row.node - x[particle]) + (w * (row.rest - 1.0)) * row.direction;
        const Mat3 J = row.direction * a.transpose() + w * Mat3::Identity();
        sum += J.transpose() * K[e.particle] * J;
      }
      D.block(first + particle) += sum;
    }
  });
}

}  // namespace brim
