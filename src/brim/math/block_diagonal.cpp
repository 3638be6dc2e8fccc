#include "brim/math/block_diagonal.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "brim/core/parallel.h"

namespace brim {

void BlockDiagonal::reset(std::span<const int> sizes) {
  size_.assign(sizes.begin(), sizes.end());
  offset_.resize(sizes.size());
  row_.resize(sizes.size());
  std::size_t offset = 0;
  rows_ = 0;
  for (std::size_t b = 0; b < sizes.size(); ++b) {
    offset_[b] = offset;
    row_[b] = rows_;
    offset += static_cast<std::size_t>(sizes[b]) * sizes[b];
    rows_ += sizes[b];
  }
  value_.assign(offset, 0.0);
}

Eigen::Map<Eigen::MatrixXd> BlockDiagonal::block(std::size_t b) {
  return {value_.data() + offset_[b], size_[b], size_[b]};
}

Eigen::Map<const Eigen::MatrixXd> BlockDiagonal::block(std::size_t b) const {
  return {value_.data() + offset_[b], size_[b], size_[b]};
}

namespace {

/// Inverse of a small symmetric matrix in place, of fixed size where the compiler can profit.
template <int N>
void invert(Eigen::Map<Eigen::MatrixXd> m) {
  using Matrix = Eigen::Matrix<double, N, N>;
  const Matrix a = m;
  const Eigen::LLT<Matrix> llt(a);
  if (llt.info() == Eigen::Success) {
    m = llt.solve(Matrix::Identity(a.rows(), a.cols()));
    return;
  }
  m.setZero();
  for (int i = 0; i < a.rows(); ++i) {
    const double d = std::abs(a(i, i));
    m(i, i) = d > 0.0 ? 1.0 / d : 1.0;
  }
}

}  // namespace

void BlockDiagonal::factor() {
  parallel_blocks(block_count(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      if (size_[b] == 3)
        invert<3>(block(b));
      else if (size_[b] == 6)
        invert<6>(block(b));
      else
        invert<Eigen::Dynamic>(block(b));
    }
  });
}

void BlockDiagonal::solve(std::span<const double> r, std::span<double> z) const { solve_from(0, r, z); }

void BlockDiagonal::solve_from(std::size_t first, std::span<const double> r, std::span<double> z) const {
  if (r.empty()) return;
  const std::size_t row = row_[first];
  const std::size_t end = std::lower_bound(row_.begin() + first, row_.end(), row + r.size()) - row_.begin();
  parallel_blocks(end - first, 1024, [&](std::size_t begin, std::size_t stop) {
    for (std::size_t b = first + begin; b < first + stop; ++b) {
      const double* a = value_.data() + offset_[b];
      const double* x = r.data() + (row_[b] - row);
      double* y = z.data() + (row_[b] - row);
      const int n = size_[b];
      for (int i = 0; i < n; ++i) {
        double sum = 0.0;
        for (int j = 0; j < n; ++j) sum += a[i * n + j] * x[j];
        y[i] = sum;
      }
    }
  });
}

}  // namespace brim
