#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "brim/math/types.h"

namespace brim {

/// Corners of a difference of two convex sets, and the point of their hull nearest to the origin.
class GapSimplex {
 public:
  explicit GapSimplex(const Vec3& first) : corner_{first}, nearest_(first) {}
  /// Adds a corner and leaves out those that the nearest point does not need.
  void add(const Vec3& corner);
  const Vec3& nearest() const { return nearest_; }
  /// True when the hull contains the origin.
  bool full() const { return count_ == 4; }
  bool has(const Vec3& corner) const {
    return std::find(corner_.begin(), corner_.begin() + count_, corner) != corner_.begin() + count_;
  }
  double largest2() const {
    double most = 0.0;
    for (int i = 0; i < count_; ++i) most = std::max(most, corner_[static_cast<std::size_t>(i)].squaredNorm());
    return most;
  }

 private:
  std::array<Vec3, 4> corner_;
  int count_ = 1;
  Vec3 nearest_;
};

/// True when two convex sets are at most `reach` apart, [m] >= 0; 0: when they meet. The point of a − b nearest to the
/// origin is found by supports alone (Gilbert, Johnson, Keerthi 1988), as far as needed for the answer.
/// @param a, b   support functions: a farthest point [m] along a direction, which need not be a unit vector
/// Where the distance is within 1e-7 of the sets' size from the reach, either answer may come.
/// Tests: tests/mesh/convex_gap_test.cpp
template <class SupportA, class SupportB>
bool within_reach(const SupportA& a, const SupportB& b, double reach) {
  constexpr int kMost = 200;
  constexpr double kExact = 1e-14;  // of squares
  const auto difference = [&](const Vec3& direction) { return Vec3(a(direction) - b(-direction)); };
  GapSimplex simplex(difference(Vec3::UnitX()));
  for (int i = 0; i < kMost; ++i) {
    const Vec3 v = simplex.nearest();
    const double v2 = v.squaredNorm();
    if (simplex.full() || v2 <= reach * reach || v2 <= kExact * kExact * simplex.largest2()) return true;
    const Vec3 w = difference(-v);
    // The plane across v through w separates the sets.
    if (v.dot(w) > reach * std::sqrt(v2)) return false;
    if (v2 - v.dot(w) <= kExact * v2 || simplex.has(w)) return false;
    simplex.add(w);
    if (!simplex.full() && simplex.nearest().squaredNorm() >= v2) return false;
  }
  return false;
}

}  // namespace brim
