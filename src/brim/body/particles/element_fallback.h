#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace brim {

/// Chooses the primitive (segment, triangle, tetrahedron) of N vertices that carries a point of the density: the
/// nearest, unless it is so flat that the point's weights w in it exceed a bound; then the best of its neighbours,
/// whose weights reproduce linear fields too, so that forces keep their torque. Tests: tests/body/fem_body_test.cpp
template <std::size_t N>
class ElementFallback {
 public:
  using Primitive = std::array<std::int32_t, N>;

  explicit ElementFallback(std::span<const Primitive> primitives) {
    std::int32_t vertices = 0;
    for (const Primitive& p : primitives)
      for (const std::int32_t i : p) vertices = std::max(vertices, i + 1);
    first_.assign(static_cast<std::size_t>(vertices) + 1, 0);
    for (const Primitive& p : primitives)
      for (const std::int32_t i : p) ++first_[i + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    around_.resize(N * primitives.size());
    std::vector<std::int32_t> next(first_);
    for (std::size_t p = 0; p < primitives.size(); ++p)
      for (const std::int32_t i : primitives[p]) around_[next[i]++] = static_cast<std::int32_t>(p);
  }

  /// @param nearest  primitive next to the point
  /// @param most     bound of Σ|w|
  /// @param sum      Σ|w| of the point in a primitive, infinite when degenerate
  /// @return the nearest also when no neighbour satisfies the bound
  template <class F>
  std::int32_t choose(std::span<const Primitive> primitives, std::int32_t nearest, double most, const F& sum) const {
    double least = sum(primitives[nearest]);
    if (least <= most) return nearest;
    std::int32_t best = nearest;
    for (const std::int32_t i : primitives[nearest])
      for (std::int32_t k = first_[i]; k < first_[i + 1]; ++k)
        if (const double s = sum(primitives[around_[k]]); s < least) least = s, best = around_[k];
    return least <= most ? best : nearest;
  }

 private:
  std::vector<std::int32_t> first_, around_;  // primitives at vertex i: around_[first_[i]] to around_[first_[i + 1]]
};

}  // namespace brim
