#include "brim/solve/dense_factor.h"

#include <algorithm>

#include "brim/core/widest.h"
#include "brim/solve/panel.h"

namespace brim {

namespace {

using panel::kBlock;

/// Calls f with the first column and the number of columns of each block. @param backward  from the last on
template <class F>
BRIM_INLINE void for_blocks(std::size_t n, bool backward, const F& f) {
  const std::size_t blocks = (n + kBlock - 1) / kBlock;
  for (std::size_t i = 0; i < blocks; ++i) {
    const std::size_t first = kBlock * (backward ? blocks - 1 - i : i);
    f(first, std::min(kBlock, n - first));
  }
}

/// x := L⁻¹ x, then L⁻ᵀ x. @param L  as panel::factor leaves it @param x  zero for a pad past n
template <class Widest>
BRIM_INLINE void solve_columns(const float* L, std::size_t stride, std::size_t n, float* x) {
  for_blocks(n, false, [&](std::size_t first, std::size_t width) BRIM_LAMBDA_INLINE {
    const float* square = L + first * stride + first;
    float y[kBlock] = {};
    for (std::size_t j = 0; j < width; ++j)
      for (std::size_t i = j; i < width; ++i) y[i] += square[j * stride + i] * x[first + j];
    std::copy(y, y + width, x + first);
    for (std::size_t i = first + width; i < n; i += kWidestLanes) {
      auto below = load_widest<Widest>(x + i);
      for (std::size_t j = 0; j < width; ++j) below -= load_widest<Widest>(L + (first + j) * stride + i) * y[j];
      store_lanes(x + i, below);
    }
    for (std::size_t i = n; i < n + panel::kPad; ++i) x[i] = 0.0f;
  });
  for_blocks(n, true, [&](std::size_t first, std::size_t width) BRIM_LAMBDA_INLINE {
    typename Widest::Floats sum[kBlock] = {};
    for (std::size_t i = first + width; i < n; i += kWidestLanes) {
      const auto below = load_widest<Widest>(x + i);
      for (std::size_t j = 0; j < width; ++j) sum[j] += load_widest<Widest>(L + (first + j) * stride + i) * below;
    }
    const float* square = L + first * stride + first;
    float y[kBlock];
    for (std::size_t j = 0; j < width; ++j) {
      float s = 0.0f, lane[kWidestLanes];
      store_lanes(lane, sum[j]);
      for (const float of_lane : lane) s += of_lane;
      y[j] = x[first + j] - s;
    }
    for (std::size_t j = 0; j < width; ++j) {
      float s = 0.0f;
      for (std::size_t i = j; i < width; ++i) s += square[j * stride + i] * y[i];
      x[first + j] = s;
    }
  });
}

BRIM_WIDEST(solve_both, (const float* L, std::size_t stride, std::size_t n, float* x),
            solve_columns<Widest>(L, stride, n, x))

}  // namespace

bool DenseFactor::factor(const Eigen::MatrixXd& A, double shift) {
  n_ = static_cast<std::size_t>(A.rows());
  stride_ = panel::padded(n_) + panel::kPad;
  panel_.assign(stride_ * n_, 0.0f);
  for (std::size_t j = 0; j < n_; ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    for (std::size_t i = j; i < n_; ++i)
      panel_[j * stride_ + i] = static_cast<float>(A(static_cast<Eigen::Index>(i), column));
    panel_[j * stride_ + j] = static_cast<float>(A(column, column) + shift);
  }
  workspace_.resize((panel::padded(n_) + panel::kPad) * kBlock);
  return panel::factor(panel_.data(), stride_, n_, n_, workspace_.data()) == 0;
}

void DenseFactor::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  x_.assign(n_ + panel::kPad, 0.0f);
  for (std::size_t i = 0; i < n_; ++i) x_[i] = static_cast<float>(b[static_cast<Eigen::Index>(i)]);
  solve_both(panel_.data(), stride_, n_, x_.data());
  x.resize(static_cast<Eigen::Index>(n_));
  for (std::size_t i = 0; i < n_; ++i) x[static_cast<Eigen::Index>(i)] = x_[i];
}

}  // namespace brim
