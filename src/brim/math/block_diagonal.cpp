#include "brim/math/block_diagonal.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "brim/core/parallel.h"
#include "brim/core/simd.h"

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
  value_.assign(offset + 1, 0.0);
}

Eigen::Map<Eigen::MatrixXd> BlockDiagonal::block(std::size_t b) {
  return {value_.data() + offset_[b], size_[b], size_[b]};
}

Eigen::Map<const Eigen::MatrixXd> BlockDiagonal::block(std::size_t b) const {
  return {value_.data() + offset_[b], size_[b], size_[b]};
}

namespace {

/// Determinant of a symmetric matrix over the product of its diagonal, above which cofactors give its inverse well.
constexpr double kFar = 1e-6;

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

/// The same of three rows by cofactors.
void invert_three(Eigen::Map<Eigen::MatrixXd> m) {
  const Mat3 a = m;
  const double c00 = a(1, 1) * a(2, 2) - a(1, 2) * a(1, 2), c01 = a(0, 2) * a(1, 2) - a(0, 1) * a(2, 2),
               c02 = a(0, 1) * a(1, 2) - a(0, 2) * a(1, 1), c22 = a(0, 0) * a(1, 1) - a(0, 1) * a(0, 1);
  const double determinant = a(0, 0) * c00 + a(0, 1) * c01 + a(0, 2) * c02;
  // Far from singular: what cancels is far above rounding.
  if (!(a(0, 0) > 0.0 && c22 > 0.0 && determinant > kFar * a(0, 0) * a(1, 1) * a(2, 2))) return invert<3>(m);
  const double c11 = a(0, 0) * a(2, 2) - a(0, 2) * a(0, 2), c12 = a(0, 1) * a(0, 2) - a(0, 0) * a(1, 2);
  const double inverse = 1.0 / determinant;
  m(0, 0) = c00 * inverse, m(1, 1) = c11 * inverse, m(2, 2) = c22 * inverse;
  m(0, 1) = m(1, 0) = c01 * inverse, m(0, 2) = m(2, 0) = c02 * inverse, m(1, 2) = m(2, 1) = c12 * inverse;
}

/// z = D⁻¹ r for blocks of three rows that follow one another. @param a  one number more than those of the blocks
BRIM_WIDE void multiply_threes(const double* a, const double* r, std::size_t blocks, double* z) {
  for (std::size_t b = 0; b < blocks; ++b, a += 9, r += 3, z += 3) {
    const Lanes y = load_lanes(a) * r[0] + load_lanes(a + 3) * r[1] + load_lanes(a + 6) * r[2];
    for (int i = 0; i < 3; ++i) z[i] = y[i];
  }
}

}  // namespace

void BlockDiagonal::factor() {
  parallel_blocks(block_count(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      if (size_[b] == 3)
        invert_three(block(b));
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
    for (std::size_t b = first + begin; b < first + stop;) {
      const double *a = value_.data() + offset_[b], *x = r.data() + (row_[b] - row);
      double* y = z.data() + (row_[b] - row);
      std::size_t threes = 0;
      while (b + threes < first + stop && size_[b + threes] == 3) ++threes;
      if (threes > 0) {  // the common case
        multiply_threes(a, x, threes, y);
        b += threes;
        continue;
      }
      const int n = size_[b++];
      for (int i = 0; i < n; ++i) {
        double sum = 0.0;
        for (int j = 0; j < n; ++j) sum += a[i * n + j] * x[j];
        y[i] = sum;
      }
    }
  });
}

}  // namespace brim
