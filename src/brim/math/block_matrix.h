#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Sparse matrix of 3x3 blocks acting on differences, as the stiffness of any body that is free in space does:
///   K_ji = K_ijᵀ,   K_ii = −Σ_{j≠i} K_ij,   (K x)_i = Σ_{j≠i} K_ij (x_j − x_i)
/// Off-diagonal blocks are kept in single precision, both K_ij and K_ji, which are exact transposes of each other;
/// diagonal blocks are sums of these in double. So a translation gives zero to rounding in double, whatever the
/// precision of the blocks; K is symmetric up to the skew part of the diagonal, 2^-24 of the blocks of its row.
///
/// The pattern is fixed once. Elements then add values through slots looked up beforehand, and close() completes them:
///   set_zero, add ..., close
/// Tests: tests/math/block_matrix_test.cpp
class BlockMatrix {
 public:
  /// Collects the pattern: every pair of nodes of an element, and the diagonal. Call begin(), add_elements() once per
  /// kind of element, then finish().
  void begin(std::size_t nodes);
  void add_elements(std::span<const std::int32_t> node_of, int per_element);
  void finish();

  // ---- pattern: row r has the blocks at slots row_first()[r] <= s < row_first()[r + 1], in columns()[s], ascending --
  std::size_t rows() const { return first_.size() - 1; }
  std::size_t block_count() const { return column_.size(); }
  std::span<const std::int32_t> row_first() const { return first_; }  ///< shape (rows + 1)
  std::span<const std::int32_t> columns() const { return column_; }   ///< shape (block_count)
  /// Slot of block (row, column), which must be in the pattern.
  std::int32_t slot(std::int32_t row, std::int32_t column) const;
  std::int32_t diagonal_slot(std::size_t row) const { return diagonal_[row]; }

  // ---- values --------------------------------------------------------------------------------------------------
  void set_zero();
  /// Where the block of a pair of different nodes is added: slot(i, j) when i < j, else ~slot(j, i).
  std::int32_t pair(std::int32_t i, std::int32_t j) const { return i < j ? slot(i, j) : ~slot(j, i); }
  /// Adds K_ij at pair(i, j); close() then derives K_ji and the diagonal. No two threads may add to one pair at a time
  /// (ElementSchedule).
  void add(std::int32_t pair, const Mat3& K);
  /// The nine numbers of the block at a slot above the diagonal, column by column, to be added to as above.
  float* values(std::int32_t slot) { return value_.data() + kEntries * static_cast<std::size_t>(slot); }
  const float* values(std::int32_t slot) const { return value_.data() + kEntries * static_cast<std::size_t>(slot); }
  /// Fills the diagonal blocks and those below the diagonal.
  void close();
  /// this = a A + b B, where A and B are closed and have this pattern; the result is closed.
  void combine(double a, const BlockMatrix& A, double b, const BlockMatrix& B);
  /// The block at a slot; a diagonal block is rounded to single precision here.
  Mat3 block(std::int32_t slot) const;
  /// K_ii in double, as used by the product.
  const Mat3& diagonal(std::size_t row) const { return diagonal_value_[row]; }

  /// y += a (this) x + b (m x),  m: one mass per row.
  /// Parallel over rows; same bits for any number of threads. Bound by memory: 40 bytes a block.
  void multiply_add(double a, double b, std::span<const double> m, std::span<const double> x,
                    std::span<double> y) const;

 private:
  static constexpr std::size_t kEntries = 9;

  void close_row(std::size_t row);

  std::vector<std::uint64_t> pattern_;  // row << 32 | column, while building
  std::vector<std::int32_t> first_{0}, column_, diagonal_;
  std::vector<std::int32_t> mirror_;       // per slot below the diagonal, in order: the slot of its transpose
  std::vector<std::size_t> mirror_first_;  // per row, shape (rows + 1)
  std::vector<float> value_;               // per slot, column by column; one extra entry at the end, for loads of four
  std::vector<Mat3> diagonal_value_;
};

/// A body's part of the system of the step: A = stiffness_share K + mass_share M, K sparse in 3x3 blocks and M
/// diagonal. Unknowns 3 i to 3 i + 2 of the body are row i of K. Views into the body: valid from begin_solve to the
/// next update.
struct BlockSystem {
  const BlockMatrix* stiffness = nullptr;
  double stiffness_share = 0.0;                ///< dt (dt + b) or 1, where K is ready-made
  double mass_share = 1.0;                     ///< 1 + dt a
  std::span<const double> mass;                ///< [kg] per row, shape (rows)
  std::span<const std::int32_t> prescribed{};  ///< rows with prescribed velocity, sorted: filtered from the solve
  /// [m] position of each row's node: rigid motions of the body have velocity t + ω × place; shape (rows) or empty
  std::span<const Vec3> place{};
  bool thin = false;  ///< rows lie on a surface or a line: a factor has few entries
};

}  // namespace brim
