#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Particles sorted by the cells they lie in, rows along x first, so that the particles of three neighbouring cells are
/// one range. Cells are a sorted list: empty space costs nothing, however far particles fly.
/// Cost: O(n log n).  Tests: tests/body/particle_fluid_test.cpp
class ParticleCells {
 public:
  /// @param x       positions, finite, [m]
  /// @param radius  [m] side of a cell, > 0: distance up to which neighbours are found
  void build(std::span<const Vec3> x, double radius);

  std::size_t size() const { return position_.size(); }
  double radius() const { return radius_; }
  /// Number in the caller's order of the k-th particle in cell order.
  std::span<const std::int32_t> order() const { return order_; }
  /// Positions in cell order, [m].
  std::span<const Vec3> positions() const { return position_; }
  /// Number of cells with particles.
  std::size_t cells() const { return key_.size(); }
  /// Numbers, in the caller's order, of the particles of a cell.
  std::span<const std::int32_t> of_cell(std::size_t cell) const {
    const auto begin = static_cast<std::size_t>(first_[cell]), end = static_cast<std::size_t>(first_[cell + 1]);
    return std::span(order_).subspan(begin, end - begin);
  }

  /// Calls f(begin, end) for the ranges, in cell order, that contain every particle within `reach` of x, and some more.
  template <class F>
  void near(const Vec3& x, double reach, const F& f) const {
    const Cell lo = cell_of(x - Vec3::Constant(reach)), hi = cell_of(x + Vec3::Constant(reach));
    for (std::int64_t z = lo.z; z <= hi.z; ++z)
      for (std::int64_t y = lo.y; y <= hi.y; ++y) {
        const std::uint64_t to = key_of({hi.x, y, z});
        std::size_t first = lower_bound(key_of({lo.x, y, z})), last = first;
        while (last < key_.size() && key_[last] <= to) ++last;
        if (last > first) f(first_[first], first_[last]);
      }
  }

  /// Calls f(particle, ranges) for the particles [begin, end) in cell order; ranges: up to nine pairs (first, last).
  template <class F>
  void for_neighbourhoods(std::size_t begin, std::size_t end, const F& f) const {
    if (begin >= end) return;
    std::size_t cell = cell_holding(begin);
    std::size_t cursor[9];
    bool fresh = true;
    std::pair<std::int32_t, std::int32_t> ranges[9];
    for (std::size_t i = begin; i < end; ++cell) {
      const Cell c = cell_at(cell);
      int count = 0;
      for (int r = 0; r < 9; ++r) {
        const std::int64_t y = c.y + r % 3 - 1, z = c.z + r / 3 - 1;
        if (fresh) cursor[r] = lower_bound(key_of({c.x - 1, y, z}));
        visit_row(c.x, y, z, cursor[r], [&](std::int32_t first, std::int32_t last) {
          ranges[count++] = {first, last};
        });
      }
      fresh = false;
      const auto last = std::min(end, static_cast<std::size_t>(first_[cell + 1]));
      for (; i < last; ++i) f(i, std::span<const std::pair<std::int32_t, std::int32_t>>(ranges, count));
    }
  }

 private:
  struct Cell {
    std::int64_t x, y, z;
  };
  static constexpr int kBits = 21;
  static constexpr std::int64_t kLargest = (std::int64_t{1} << kBits) - 8;

  Cell cell_of(const Vec3& x) const;
  Cell cell_at(std::size_t cell) const;
  std::uint64_t key_of(const Cell& c) const;
  std::size_t lower_bound(std::uint64_t key) const;
  std::size_t cell_holding(std::size_t particle) const;
  /// Advances the cursor to the first cell at or after (x − 1, y, z) and reports the range of cells x − 1 to x + 1.
  template <class F>
  void visit_row(std::int64_t x, std::int64_t y, std::int64_t z, std::size_t& cursor, const F& f) const {
    const std::uint64_t from = key_of({x - 1, y, z}), to = from + 2;
    while (cursor < key_.size() && key_[cursor] < from) ++cursor;
    std::size_t last = cursor;
    while (last < key_.size() && key_[last] <= to) ++last;
    if (last > cursor) f(first_[cursor], first_[last]);
  }

  double radius_ = 0.0, inverse_ = 0.0;
  Vec3 origin_ = Vec3::Zero();
  std::vector<std::pair<std::uint64_t, std::int32_t>> sorted_;
  std::vector<std::int32_t> order_;
  std::vector<Vec3> position_;
  std::vector<std::uint64_t> key_;   ///< of each cell with particles, ascending
  std::vector<std::int32_t> first_;  ///< first particle of each cell, and the end
};

}  // namespace brim
