#include "brim/body/particles/particle_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace brim {

// Digits of a key start at 0 for coordinate -2, so that a step to the side never leaves them.
ParticleCells::Cell ParticleCells::cell_of(const Vec3& x) const {
  const auto digit = [&](int a) {
    const double c = std::floor((x[a] - origin_[a]) * inverse_);
    return static_cast<std::int64_t>(std::clamp(c, -1.0, static_cast<double>(kLargest)));
  };
  return {digit(0), digit(1), digit(2)};
}

std::uint64_t ParticleCells::key_of(const Cell& c) const {
  return static_cast<std::uint64_t>(c.x + 2) | static_cast<std::uint64_t>(c.y + 2) << kBits |
         static_cast<std::uint64_t>(c.z + 2) << (2 * kBits);
}

ParticleCells::Cell ParticleCells::cell_at(std::size_t cell) const {
  constexpr std::uint64_t mask = (std::uint64_t{1} << kBits) - 1;
  const std::uint64_t k = key_[cell];
  return {static_cast<std::int64_t>(k & mask) - 2, static_cast<std::int64_t>(k >> kBits & mask) - 2,
          static_cast<std::int64_t>(k >> (2 * kBits)) - 2};
}

std::size_t ParticleCells::lower_bound(std::uint64_t key) const {
  return static_cast<std::size_t>(std::lower_bound(key_.begin(), key_.end(), key) - key_.begin());
}

std::size_t ParticleCells::cell_holding(std::size_t particle) const {
  const auto it = std::upper_bound(first_.begin(), first_.end(), static_cast<std::int32_t>(particle));
  return static_cast<std::size_t>(it - first_.begin()) - 1;
}

void ParticleCells::build(std::span<const Vec3> x, double radius) {
  radius_ = radius;
  inverse_ = 1.0 / radius;
  Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity());
  for (const Vec3& p : x) lo = lo.cwiseMin(p);
  origin_ = x.empty() ? Vec3::Zero() : lo;
  sorted_.resize(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) sorted_[i] = {key_of(cell_of(x[i])), static_cast<std::int32_t>(i)};
  std::sort(sorted_.begin(), sorted_.end());
  order_.resize(x.size()), position_.resize(x.size());
  key_.clear(), first_.clear();
  for (std::size_t k = 0; k < x.size(); ++k) {
    order_[k] = sorted_[k].second;
    position_[k] = x[static_cast<std::size_t>(order_[k])];
    if (key_.empty() || key_.back() != sorted_[k].first) {
      key_.push_back(sorted_[k].first);
      first_.push_back(static_cast<std::int32_t>(k));
    }
  }
  first_.push_back(static_cast<std::int32_t>(x.size()));
}

}  // namespace brim
