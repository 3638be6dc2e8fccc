#include "brim/response/patch_average.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {

/// Largest number of lattice points of a dense array per point, and the number that is always allowed.
constexpr double kMostPerPoint = 8.0, kGranted = 512.0;

std::array<std::int64_t, 3> corner(const std::array<std::int64_t, 3>& base, int c) {
  return {base[0] + (c & 1), base[1] + (c >> 1 & 1), base[2] + (c >> 2)};
}

}  // namespace

void PatchLattice::place(std::span<const Vec3> x, double cell, const Vec3& origin) {
  place_.resize(x.size()), base_.resize(x.size());
  size_ = 0;
  if (x.empty()) return;
  const double inverse = 1.0 / cell;
  std::array<std::int64_t, 3> lo{}, hi{};
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 p = (x[i] - origin) * inverse;
    std::array<float, 3> t{};
    for (int a = 0; a < 3; ++a) {
      // Rounds down without a library call.
      base_[i][a] = static_cast<std::int64_t>(p[a]);
      base_[i][a] -= static_cast<double>(base_[i][a]) > p[a];
      const auto below = static_cast<double>(base_[i][a]);
      t[a] = static_cast<float>(p[a] - below);
      lo[a] = i == 0 ? base_[i][a] : std::min(lo[a], base_[i][a]);
      hi[a] = i == 0 ? base_[i][a] : std::max(hi[a], base_[i][a]);
    }
    for (int c = 0; c < 8; ++c)
      place_[i].weight[c] =
          (c & 1 ? t[0] : 1.0f - t[0]) * (c >> 1 & 1 ? t[1] : 1.0f - t[1]) * (c >> 2 ? t[2] : 1.0f - t[2]);
  }
  const std::int64_t nx = hi[0] - lo[0] + 2, ny = hi[1] - lo[1] + 2, nz = hi[2] - lo[2] + 2;
  const double volume = static_cast<double>(nx) * static_cast<double>(ny) * static_cast<double>(nz);
  if (volume <= kGranted + kMostPerPoint * static_cast<double>(x.size())) {
    size_ = static_cast<std::size_t>(volume);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::int64_t first = base_[i][0] - lo[0] + nx * (base_[i][1] - lo[1] + ny * (base_[i][2] - lo[2]));
      for (int c = 0; c < 8; ++c)
        place_[i].slot[c] = static_cast<std::int32_t>(first + (c & 1) + nx * ((c >> 1 & 1) + ny * (c >> 2)));
    }
    return;
  }
  used_.clear();
  for (const auto& b : base_)
    for (int c = 0; c < 8; ++c) used_.push_back(corner(b, c));
  std::sort(used_.begin(), used_.end());
  used_.erase(std::unique(used_.begin(), used_.end()), used_.end());
  size_ = used_.size();
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int c = 0; c < 8; ++c)
      place_[i].slot[c] =
          static_cast<std::int32_t>(std::lower_bound(used_.begin(), used_.end(), corner(base_[i], c)) - used_.begin());
}

}  // namespace brim
