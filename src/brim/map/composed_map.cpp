#include "brim/map/composed_map.h"

#include <cmath>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

void ComposedMap::assign(WeightRows rows, std::unique_ptr<Map> inner) {
  rows_ = std::move(rows);
  inner_ = std::move(inner);
  particle_.resize(inner_->points());
  transpose_.build(particle_.size(), rows_.first, rows_.source);
}

void ComposedMap::apply(std::span<const double> v, std::span<Vec3> u) const {
  inner_->apply(v, particle_);
  apply_rows(rows_, {particle_.data()->data(), 3 * particle_.size()}, u);
}

void ComposedMap::spread(std::span<const Vec3> f) const {
  BRIM_CHECK(f.size(), ==, points());
  std::fill(particle_.begin(), particle_.end(), Vec3::Zero());
  add_transpose(rows_, transpose_, f, {particle_.data()->data(), 3 * particle_.size()});
}

void ComposedMap::apply_transpose(std::span<const Vec3> f, std::span<double> Q) const {
  spread(f);
  inner_->apply_transpose(particle_, Q);
}

void ComposedMap::add_geometric(std::span<const Vec3> f, std::span<const double> dq, std::span<double> Q) const {
  spread(f);
  inner_->add_geometric(particle_, dq, Q);
}

void ComposedMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  BRIM_CHECK(K.size(), ==, points());
  const auto size_of = [this](std::int32_t e) {
    return std::abs(rows_.weight[e]) + (rows_.lever.empty() ? 0.0 : rows_.lever[e].norm());
  };
  std::vector<double> sum(points(), 0.0);
  for (std::size_t p = 0; p < points(); ++p)
    for (std::int32_t e = rows_.first[p]; e < rows_.first[p + 1]; ++e) sum[p] += size_of(e);
  std::vector<Mat3> lumped(particle_.size(), Mat3::Zero());
  parallel_for(
      transpose_.columns.size(),
      [&](std::size_t c) {
        Mat3& k = lumped[transpose_.columns[c]];
        for (const auto& e : transpose_.of(c)) {
          // A lever turns forces along n into any direction.
          const Mat3 here = rows_.lever.empty() ? K[e.row] : Mat3(K[e.row].trace() * Mat3::Identity());
          k += size_of(e.index) * sum[e.row] * here;
        }
      },
      64);
  inner_->add_block_diagonal(lumped, first, D);
}

}  // namespace brim
