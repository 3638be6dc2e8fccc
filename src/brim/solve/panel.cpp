#include "brim/solve/panel.h"

#include <algorithm>
#include <cmath>

#include "brim/core/widest.h"

namespace brim::panel {

namespace {

/// y[0, n) -= s x[0, n)
BRIM_INLINE void subtract(float* __restrict y, const float* __restrict x, float s, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) y[i] -= s * x[i];
}

/// L := L⁻¹ in place, L lower triangular; what is above the diagonal is left alone.
BRIM_INLINE void invert_triangle(float* L, std::size_t stride, std::size_t n) {
  // From the last column on: those after j are inverses already.
  for (std::size_t j = n; j-- > 0;) {
    float* column = L + j * stride;
    const float inverse = 1.0f / column[j];
    // x = −L₂₂⁻¹ l / L_jj, L₂₂⁻¹ standing in the columns after j.
    float x[kBlock] = {};
    for (std::size_t k = j + 1; k < n; ++k)
      for (std::size_t i = k; i < n; ++i) x[i] -= L[k * stride + i] * column[k];
    column[j] = inverse;
    for (std::size_t i = j + 1; i < n; ++i) column[i] = x[i] * inverse;
  }
}

/// Replaces the lower triangle of a small matrix by its Cholesky factor. @return pivots that were lifted
BRIM_INLINE int factor_triangle(float* L, std::size_t stride, std::size_t n) {
  int lifted = 0;
  for (std::size_t k = 0; k < n; ++k) {
    float* column = L + k * stride;
    for (std::size_t j = 0; j < k; ++j) {
      const float s = L[j * stride + k];
      for (std::size_t i = k; i < n; ++i) column[i] -= L[j * stride + i] * s;
    }
    if (!(column[k] >= kLeastPivot)) column[k] = kLeastPivot, ++lifted;
    const float root = std::sqrt(column[k]), inverse = 1.0f / root;
    column[k] = root;
    for (std::size_t i = k + 1; i < n; ++i) column[i] *= inverse;
  }
  return lifted;
}

/// B := B L⁻ᵀ for rows [from, from + rows) below a square of N columns that holds L⁻¹, counted from its first.
template <int N>
BRIM_INLINE void divide(float* square, std::size_t stride, std::size_t from, std::size_t rows) {
  const auto combine = [&](auto(&b)[N]) {
    for (int j = N; j-- > 0;) {
      b[j] *= square[static_cast<std::size_t>(j) * stride + static_cast<std::size_t>(j)];
      for (int k = 0; k < j; ++k)
        b[j] += b[k] * square[static_cast<std::size_t>(k) * stride + static_cast<std::size_t>(j)];
    }
  };
  std::size_t i = from;
  for (; i + kWideLanes <= from + rows; i += kWideLanes) {
    WideFloats b[N];
    for (int k = 0; k < N; ++k) b[k] = load_wide(square + static_cast<std::size_t>(k) * stride + i);
    combine(b);
    for (int k = 0; k < N; ++k) store_wide(b[k], square + static_cast<std::size_t>(k) * stride + i);
  }
  for (; i < from + rows; ++i) {
    float b[N];
    for (int k = 0; k < N; ++k) b[k] = square[static_cast<std::size_t>(k) * stride + i];
    combine(b);
    for (int k = 0; k < N; ++k) square[static_cast<std::size_t>(k) * stride + i] = b[k];
  }
}

/// c[j] = Σ_k a_k b_kj for sixteen rows and N columns.
template <class Widest, int N>
BRIM_INLINE void multiply_columns(const float* a, const float* b, std::size_t stride, std::size_t depth, float* c,
                                  std::size_t out) {
  typename Widest::Floats s[N] = {};
  for (std::size_t k = 0; k < depth; ++k, a += stride, b += stride) {
    const auto x = load_widest<Widest>(a);
#pragma GCC unroll 12
    for (int j = 0; j < N; ++j) s[j] += x * b[j];
  }
#pragma GCC unroll 12
  for (int j = 0; j < N; ++j, c += out) store_lanes(c, s[j]);
}

template <class Widest>
BRIM_INLINE void multiply_rows(const float* a, const float* b, std::size_t stride, std::size_t rows,
                               std::size_t columns, std::size_t depth, float* c) {
  const std::size_t out = padded(rows);
  for (std::size_t i = 0; i < rows; i += kWidestLanes) {
    std::size_t j = 0;
    for (; j + 6 <= columns; j += 6) multiply_columns<Widest, 6>(a + i, b + j, stride, depth, c + j * out + i, out);
    for (; j < columns; j += 3) multiply_columns<Widest, 3>(a + i, b + j, stride, depth, c + j * out + i, out);
  }
}

BRIM_WIDEST(multiply,
            (const float* a, const float* b, std::size_t stride, std::size_t rows, std::size_t columns,
             std::size_t depth, float* c),
            multiply_rows<Widest>(a, b, stride, rows, columns, depth, c))

}  // namespace

void multiply_transposed(const float* a, const float* b, std::size_t stride, std::size_t rows, std::size_t columns,
                         std::size_t depth, float* c) {
  multiply(a, b, stride, rows, columns, depth, c);
}

BRIM_WIDE void subtract_runs(const float* product, std::size_t stride, const Run* run, std::size_t runs,
                             float* const* column, std::size_t columns) {
  for (std::size_t r = 0; r < runs; ++r) {
    const auto [from, to, length] = run[r];
    const float* x = product + from;
    if (length == 3) {
      for (std::size_t j = 0; j < columns; ++j, x += stride) {
        float* y = column[j] + to;
        y[0] -= x[0], y[1] -= x[1], y[2] -= x[2];
      }
      continue;
    }
    const std::size_t full = length / kWideLanes * kWideLanes;
    for (std::size_t j = 0; j < columns; ++j, x += stride) {
      float* y = column[j] + to;
      std::size_t i = 0;
      for (; i < full; i += kWideLanes) store_wide(load_wide(y + i) - load_wide(x + i), y + i);
      if (i + 4 <= length) store_lanes(y + i, FloatLanes(load_lanes(y + i) - load_lanes(x + i))), i += 4;
      for (; i < length; ++i) y[i] -= x[i];
    }
  }
}

/// Takes from rows [from, from + rows) of the block's columns what the columns before have for them.
BRIM_INLINE void take_columns_before(float* panel, std::size_t stride, std::size_t first, std::size_t block,
                                     std::size_t from, std::size_t rows, float* workspace) {
  if (first == 0) return;
  const std::size_t out = padded(rows);
  multiply_transposed(panel + from, panel + first, stride, rows, block, first, workspace);
  for (std::size_t j = 0; j < block; ++j)
    subtract(panel + (first + j) * stride + from, workspace + j * out, 1.0f, rows);
}

BRIM_WIDE int factor_square(float* panel, std::size_t stride, std::size_t first, std::size_t block, float* workspace) {
  take_columns_before(panel, stride, first, block, first, block, workspace);
  float* square = panel + first * stride + first;
  const int lifted = factor_triangle(square, stride, block);
  invert_triangle(square, stride, block);
  return lifted;
}

BRIM_WIDE void factor_rows(float* panel, std::size_t stride, std::size_t first, std::size_t block, std::size_t from,
                           std::size_t rows, float* workspace) {
  take_columns_before(panel, stride, first, block, from, rows, workspace);
  float* square = panel + first * stride + first;
  switch (block) {
    case 3:
      return divide<3>(square, stride, from - first, rows);
    case 6:
      return divide<6>(square, stride, from - first, rows);
    case 9:
      return divide<9>(square, stride, from - first, rows);
    default:
      return divide<12>(square, stride, from - first, rows);
  }
}

int factor(float* panel, std::size_t stride, std::size_t rows, std::size_t width, float* workspace) {
  int lifted = 0;
  for (std::size_t first = 0; first < width; first += kBlock) {
    const std::size_t block = std::min(kBlock, width - first), end = first + block;
    lifted += factor_square(panel, stride, first, block, workspace);
    if (rows > end) factor_rows(panel, stride, first, block, end, rows - end, workspace);
  }
  return lifted;
}

}  // namespace brim::panel
