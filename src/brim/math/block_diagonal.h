#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Symmetric positive definite block-diagonal matrix, dense blocks of any sizes: the preconditioner of the step.
/// Bodies and maps add to the blocks; factor() then prepares solve().
class BlockDiagonal {
 public:
  /// Sets every block to zero. @param sizes  rows of each block, >= 1
  void reset(std::span<const int> sizes);

  std::size_t block_count() const { return offset_.size(); }
  int block_size(std::size_t b) const { return size_[b]; }
  /// Row of the first unknown of block b.
  std::size_t block_row(std::size_t b) const { return row_[b]; }
  std::size_t rows() const { return rows_; }

  /// Block b, to be added to, shape (size of the block, size of the block). Valid until factor().
  Eigen::Map<Eigen::MatrixXd> block(std::size_t b);
  Eigen::Map<const Eigen::MatrixXd> block(std::size_t b) const;

  /// Replaces each block by its inverse. A block that is not positive definite is replaced by the inverse of the
  /// absolute values of its diagonal, so that solve() is always defined.
  void factor();
  /// z = D⁻¹ r, after factor().
  void solve(std::span<const double> r, std::span<double> z) const;
  /// The same for the blocks from `first` on that r covers. @param r, z  shape (sum of the sizes of these blocks)
  void solve_from(std::size_t first, std::span<const double> r, std::span<double> z) const;

 private:
  std::vector<int> size_;
  std::vector<std::size_t> offset_, row_;
  std::vector<double> value_;  ///< one extra entry at the end, for wide loads
  std::size_t rows_ = 0;
};

}  // namespace brim
