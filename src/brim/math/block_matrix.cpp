#include "brim/math/block_matrix.h"

#include <algorithm>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/math/block_rows.h"

namespace brim {

namespace {

constexpr std::size_t kRowsAtOnce = 256;

}  // namespace

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
  mirror_.clear();
  mirror_first_.assign(1, 0);
  for (std::size_t r = 0; r < rows(); ++r) {
    for (std::int32_t s = first_[r]; s < diagonal_[r]; ++s)
      mirror_.push_back(slot(column_[s], static_cast<std::int32_t>(r)));
    mirror_first_.push_back(mirror_.size());
  }
  value_.assign(kEntries * column_.size() + 1, 0.0f);
  diagonal_value_.assign(rows(), Mat3::Zero());
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
  parallel_blocks(value_.size(), 65536, [&](std::size_t begin, std::size_t end) {
    std::fill(value_.begin() + static_cast<std::ptrdiff_t>(begin), value_.begin() + static_cast<std::ptrdiff_t>(end),
              0.0f);
  });
  std::fill(diagonal_value_.begin(), diagonal_value_.end(), Mat3::Zero());
}

void BlockMatrix::add(std::int32_t pair, const Mat3& K) {
  using Block = Eigen::Matrix3f;
  if (pair >= 0)
    Eigen::Map<Block>(values(pair)) += K.cast<float>();
  else
    Eigen::Map<Block>(values(~pair)) += K.transpose().cast<float>();
}

Mat3 BlockMatrix::block(std::int32_t slot) const {
  return Eigen::Map<const Eigen::Matrix3f>(value_.data() + kEntries * static_cast<std::size_t>(slot)).cast<double>();
}

void BlockMatrix::close_row(std::size_t row) {
  using Block = Eigen::Matrix3f;
  Mat3 sum = Mat3::Zero();
  const std::int32_t* from = mirror_.data() + mirror_first_[row];
  for (std::int32_t s = first_[row]; s < diagonal_[row]; ++s, ++from) {
    const Block lower = Eigen::Map<const Block>(values(*from)).transpose();
    Eigen::Map<Block>(values(s)) = lower;
    sum -= lower.cast<double>();
  }
  for (std::int32_t s = diagonal_[row] + 1; s < first_[row + 1]; ++s)
    sum -= Eigen::Map<const Block>(values(s)).cast<double>();
  diagonal_value_[row] = sum;
  Eigen::Map<Block>(values(diagonal_[row])) = sum.cast<float>();
}

void BlockMatrix::close() {
  parallel_blocks(rows(), kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) close_row(r);
  });
}

void BlockMatrix::combine(double a, const BlockMatrix& A, double b, const BlockMatrix& B) {
  BRIM_CHECK(A.value_.size(), ==, value_.size());
  BRIM_CHECK(B.value_.size(), ==, value_.size());
  parallel_blocks(value_.size(), 65536, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) value_[k] = static_cast<float>(a * A.value_[k] + b * B.value_[k]);
  });
  close();
}

void BlockMatrix::multiply_add(double a, double b, std::span<const double> m, std::span<const double> x,
                               std::span<double> y) const {
  BRIM_CHECK(x.size(), ==, 3 * rows());
  BRIM_CHECK(y.size(), ==, 3 * rows());
  profile_bytes(static_cast<double>(value_.size() * sizeof(float) + column_.size() * sizeof(std::int32_t) +
                                    rows() * (sizeof(Mat3) + 10 * sizeof(double))));
  const detail::BlockRows rows_of{first_.data(), diagonal_.data(), column_.data(), value_.data(),
                                  diagonal_value_.data()};
  static const auto multiply = detail::has_wide_rows() ? detail::multiply_rows_wide : detail::multiply_rows;
  parallel_blocks(rows(), kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
    multiply(rows_of, begin, end, a, b, m.data(), x.data(), y.data());
  });
}

}  // namespace brim
