#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Sparse symmetric matrix of 3x3 blocks, all blocks stored, rows compressed. The pattern is fixed once; values are
/// filled by elements through slots found beforehand.
class BlockMatrix {
 public:
  /// Collects the pattern: every pair of nodes of an element, and the diagonal. Call begin, add once per kind of
  /// element, finish.
  void begin(std::size_t nodes);
  void add_elements(std::span<const std::int32_t> node_of, int per_element);
  void finish();

  std::size_t rows() const { return first_.size() - 1; }
  std::size_t block_count() const { return column_.size(); }
  /// Place of block (row, column), which must be in the pattern.
  std::int32_t slot(std::int32_t row, std::int32_t column) const;
  std::int32_t diagonal_slot(std::size_t row) const { return diagonal_[row]; }

  void set_zero();
  /// Adds to the block at a slot; the caller keeps two threads away from one slot (ElementSchedule).
  void add(std::int32_t slot, const Mat3& block) { value_[slot] += block; }
  const Mat3& block(std::int32_t slot) const { return value_[slot]; }

  /// y += a (this) x + b (m x),  m: one mass per row.
  /// Parallel over rows; same bits for any number of threads. Bound by memory: 76 bytes a block.
  void multiply_add(double a, double b, std::span<const double> m, std::span<const double> x,
                    std::span<double> y) const;

 private:
  std::vector<std::uint64_t> pattern_;  // row << 32 | column, while building
  std::vector<std::int32_t> first_{0}, column_, diagonal_;
  std::vector<Mat3> value_;
};

}  // namespace brim
