#include "brim/body/particles/block_matrix.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

void BlockMatrix::begin(std::size_t nodes) {
  pattern_.clear();
  for (std::size_t i = 0; i < nodes; ++i) pattern_.push_back(i << 32 | i);
  first_.assign(nodes + 1, 0);
}

void BlockMatrix::add_elements(std::span<const std::int32_t> node_of, int per_element) {
  for (std::size_t e = 0; e + per_element <= node_of.size(); e += per_element)
    for (int i = 0; i < per_element; ++i)
      for (int j = 0; j < per_element; ++j)
        pattern_.push_back(static_cast<std::uint64_t>(node_of[e + i]) << 32 |
                           static_cast<std::uint32_t>(node_of[e + j]));
}

void BlockMatrix::finish() {
  std::sort(pattern_.begin(), pattern_.end());
  pattern_.erase(std::unique(pattern_.begin(), pattern_.end()), pattern_.end());
  column_.clear();
  diagonal_.assign(rows(), 0);
  for (const std::uint64_t p : pattern_) {
    const auto row = static_cast<std::size_t>(p >> 32);
    const auto column = static_cast<std::int32_t>(p & 0xffffffffu);
    if (row == static_cast<std::size_t>(column)) diagonal_[row] = static_cast<std::int32_t>(column_.size());
    column_.push_back(column);
    ++first_[row + 1];
  }
  for (std::size_t r = 0; r < rows(); ++r) first_[r + 1] += first_[r];
  value_.assign(column_.size(), Mat3::Zero());
  pattern_.clear();
  pattern_.shrink_to_fit();
}

std::int32_t BlockMatrix::slot(std::int32_t row, std::int32_t column) const {
  const auto begin = column_.begin() + first_[row], end = column_.begin() + first_[row + 1];
  const auto it = std::lower_bound(begin, end, column);
  BRIM_CHECK((it != end && *it == column), ==, true);
  return static_cast<std::int32_t>(it - column_.begin());
}

void BlockMatrix::set_zero() {
  parallel_blocks(value_.size(), 8192, [&](std::size_t begin, std::size_t end) {
    std::fill(value_.begin() + begin, value_.begin() + end, Mat3::Zero());
  });
}

void BlockMatrix::multiply_add(double a, double b, std::span<const double> m, std::span<const double> x,
                               std::span<double> y) const {
  BRIM_CHECK(x.size(), ==, 3 * rows());
  BRIM_CHECK(y.size(), ==, 3 * rows());
  parallel_blocks(rows(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      double y0 = 0.0, y1 = 0.0, y2 = 0.0;
      for (std::int32_t s = first_[r]; s < first_[r + 1]; ++s) {
        const double* B = value_[s].data();  // column by column
        const double* xs = x.data() + 3 * column_[s];
        y0 += B[0] * xs[0] + B[3] * xs[1] + B[6] * xs[2];
        y1 += B[1] * xs[0] + B[4] * xs[1] + B[7] * xs[2];
        y2 += B[2] * xs[0] + B[5] * xs[1] + B[8] * xs[2];
      }
      const double bm = b * m[r];
      y[3 * r] += a * y0 + bm * x[3 * r];
      y[3 * r + 1] += a * y1 + bm * x[3 * r + 1];
      y[3 * r + 2] += a * y2 + bm * x[3 * r + 2];
    }
  });
}

}  // namespace brim
