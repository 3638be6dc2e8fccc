#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Finds the pairs of balls whose surfaces are closer than a gap: centres sorted into cells, each compared with the 27
/// cells around its own. O(n log n + pairs); memory is kept between calls. Same pairs in the same order for any number
/// of threads.  Tests: tests/body/points_body_test.cpp
class NeighbourSearch {
 public:
  struct Pair {
    std::int32_t a, b;  // a < b
    auto operator<=>(const Pair&) const = default;
  };

  /// @param x       centres, [m]; pairs with a centre that is not finite are left out
  /// @param radius  [m] one per ball, >= 0
  /// @param gap     [m] >= 0
  /// @return pairs with |x_a − x_b| < r_a + r_b + gap, sorted; valid until the next call
  std::span<const Pair> find(std::span<const Vec3> x, std::span<const double> radius, double gap);

 private:
  struct Entry {
    std::uint64_t cell;  // z << 42 | y << 21 | x
    std::int32_t ball;
    auto operator<=>(const Entry&) const = default;
  };
  void sort_into_cells(std::span<const Vec3> x, double cell);
  template <class F>
  void for_neighbours(std::size_t i, const F& f) const;

  std::vector<Entry> sorted_;
  std::vector<std::uint64_t> cell_of_;  // per ball
  std::vector<std::size_t> first_;      // of each ball's pairs
  std::vector<Pair> pairs_;
};

}  // namespace brim
