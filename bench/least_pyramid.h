#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "brim/core/parallel.h"
#include "brim/math/types.h"

namespace brim {

/// The least value of a field on cells, in blocks of 4 cells a side, of 8, of 16 and so on: a hierarchy that is built
/// from its finest level up, as the paper has it for bodies that rasterize themselves (section 6). One pass over the
/// cells, then whether a box holds a value below some other costs a few blocks and the cells on its border.
/// Measured in presence_bench.cpp, which also holds its answers to those of a scan; the library scans.
class LeastPyramid {
 public:
  /// @param cells  along x, y, z  @param value  shape (cells), x fastest; must outlive this
  void build(const Vec3i& cells, std::span<const double> value);
  /// True when a cell lo <= c <= hi has a value below `most`. The box must lie within the cells.
  bool any_below(const Vec3i& lo, const Vec3i& hi, double most) const;

 private:
  static constexpr int kBlock = 4;  // [cells] of the finest blocks
  struct Level {
    Vec3i blocks;
    std::vector<double> least;
    std::size_t at(const Vec3i& b) const {
      return static_cast<std::size_t>(b.x()) +
             static_cast<std::size_t>(blocks.x()) *
                 (static_cast<std::size_t>(b.y()) +
                  static_cast<std::size_t>(blocks.y()) * static_cast<std::size_t>(b.z()));
    }
  };
  bool below(std::size_t level, const Vec3i& block, const Vec3i& lo, const Vec3i& hi, double most) const;

  Vec3i cells_ = Vec3i::Zero();
  std::span<const double> value_;
  std::vector<Level> levels_;  // finest first; the last is one block
};

inline void LeastPyramid::build(const Vec3i& cells, std::span<const double> value) {
  cells_ = cells, value_ = value;
  levels_.clear();
  Level fine;
  fine.blocks = ((cells.array() + kBlock - 1) / kBlock).matrix();
  fine.least.assign(static_cast<std::size_t>(fine.blocks.x()) * fine.blocks.y() * fine.blocks.z(),
                    std::numeric_limits<double>::infinity());
  parallel_for(static_cast<std::size_t>(fine.blocks.z()), [&](std::size_t slab) {
    const int first = static_cast<int>(slab) * kBlock;
    for (int k = first; k < std::min(first + kBlock, cells.z()); ++k)
      for (int j = 0; j < cells.y(); ++j) {
        const double* row = value.data() + static_cast<std::size_t>(cells.x()) *
                                               (j + static_cast<std::size_t>(cells.y()) * static_cast<std::size_t>(k));
        double* least = fine.least.data() + fine.at({0, j / kBlock, static_cast<int>(slab)});
        for (int i = 0; i < cells.x(); ++i) least[i / kBlock] = std::min(least[i / kBlock], row[i]);
      }
  });
  levels_.push_back(std::move(fine));
  while (levels_.back().least.size() > 1) {
    const Level& below = levels_.back();
    Level next;
    next.blocks = ((below.blocks.array() + 1) / 2).matrix();
    next.least.assign(static_cast<std::size_t>(next.blocks.x()) * next.blocks.y() * next.blocks.z(),
                      std::numeric_limits<double>::infinity());
    for (int k = 0; k < below.blocks.z(); ++k)
      for (int j = 0; j < below.blocks.y(); ++j)
        for (int i = 0; i < below.blocks.x(); ++i) {
          double& least = next.least[next.at({i / 2, j / 2, k / 2})];
          least = std::min(least, below.least[below.at({i, j, k})]);
        }
    levels_.push_back(std::move(next));
  }
}

inline bool LeastPyramid::any_below(const Vec3i& lo, const Vec3i& hi, double most) const {
  if (levels_.empty() || (lo.array() > hi.array()).any()) return false;
  return below(levels_.size() - 1, Vec3i::Zero(), lo, hi, most);
}

inline bool LeastPyramid::below(std::size_t level, const Vec3i& block, const Vec3i& lo, const Vec3i& hi,
                                double most) const {
  const Level& l = levels_[level];
  if (!(l.least[l.at(block)] < most)) return false;
  const int side = kBlock << level;
  const Vec3i first = side * block, last = (first + Vec3i::Constant(side - 1)).cwiseMin(cells_ - Vec3i::Ones());
  if ((first.array() >= lo.array()).all() && (last.array() <= hi.array()).all()) return true;
  const Vec3i from = first.cwiseMax(lo), to = last.cwiseMin(hi);
  if (level == 0) {
    for (int k = from.z(); k <= to.z(); ++k)
      for (int j = from.y(); j <= to.y(); ++j)
        for (int i = from.x(); i <= to.x(); ++i)
          if (value_[static_cast<std::size_t>(i) +
                     static_cast<std::size_t>(cells_.x()) *
                         (j + static_cast<std::size_t>(cells_.y()) * static_cast<std::size_t>(k))] < most)
            return true;
    return false;
  }
  const int half = side / 2;
  for (int k = from.z() / half; k <= to.z() / half; ++k)
    for (int j = from.y() / half; j <= to.y() / half; ++j)
      for (int i = from.x() / half; i <= to.x() / half; ++i)
        if (below(level - 1, {i, j, k}, lo, hi, most)) return true;
  return false;
}

}  // namespace brim
