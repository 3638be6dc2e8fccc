#include "brim/solve/panel.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "brim/core/simd.h"

namespace brim::panel {

namespace {

constexpr int kWide = 8;
typedef float Wide __attribute__((vector_size(kWide * sizeof(float))));
/// Columns of a block that is factored by itself before the rest of the panel follows.
constexpr std::size_t kBlock = 12;

BRIM_INLINE Wide load(const float* p) {
  Wide w;
  __builtin_memcpy(&w, p, sizeof w);
  return w;
}
BRIM_INLINE void store(float* p, Wide w) { __builtin_memcpy(p, &w, sizeof w); }

/// y[0, n) -= s x[0, n)
BRIM_INLINE void subtract(float* __restrict y, const float* __restrict x, float s, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) y[i] -= s * x[i];
}

/// The sum of the lanes, in an order that does not depend on the machine.
BRIM_INLINE float sum_of(Wide s) { return ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7])); }

}  // namespace

BRIM_WIDE void multiply_transposed(const float* a, const float* b, std::size_t stride, std::size_t rows,
                                   std::size_t columns, std::size_t depth, float* c) {
  const std::size_t out = padded(rows);
  for (std::size_t i = 0; i < rows; i += 2 * kWide)
    for (std::size_t j = 0; j < columns; j += 3) {
      Wide s00{}, s01{}, s02{}, s10{}, s11{}, s12{};
      const float *ak = a + i, *bk = b + j;
      for (std::size_t k = 0; k < depth; ++k, ak += stride, bk += stride) {
        const Wide x0 = load(ak), x1 = load(ak + kWide);
        s00 += x0 * bk[0], s10 += x1 * bk[0];
        s01 += x0 * bk[1], s11 += x1 * bk[1];
        s02 += x0 * bk[2], s12 += x1 * bk[2];
      }
      float* ci = c + j * out + i;
      store(ci, s00), store(ci + kWide, s10);
      store(ci + out, s01), store(ci + out + kWide, s11);
      store(ci + 2 * out, s02), store(ci + 2 * out + kWide, s12);
    }
}

BRIM_WIDE int factor(float* panel, std::size_t stride, std::size_t rows, std::size_t width, float* workspace) {
  int lifted = 0;
  for (std::size_t first = 0; first < width; first += kBlock) {
    const std::size_t block = std::min(kBlock, width - first);
    if (first > 0) {
      // What the columns before take from this block.
      const std::size_t n = rows - first, out = padded(n);
      multiply_transposed(panel + first, panel + first, stride, n, block, first, workspace);
      for (std::size_t j = 0; j < block; ++j)
        subtract(panel + (first + j) * stride + first, workspace + j * out, 1.0f, n);
    }
    for (std::size_t k = first; k < first + block; ++k) {
      float* column = panel + k * stride;
      for (std::size_t j = first; j < k; ++j)
        subtract(column + k, panel + j * stride + k, panel[j * stride + k], rows - k);
      if (!(column[k] >= kLeastPivot)) column[k] = kLeastPivot, ++lifted;
      const float root = std::sqrt(column[k]), inverse = 1.0f / root;
      column[k] = root;
      for (std::size_t i = k + 1; i < rows; ++i) column[i] *= inverse;
    }
  }
  return lifted;
}

BRIM_WIDE void invert(float* panel, std::size_t stride, std::size_t rows, std::size_t width, float* workspace) {
  const std::size_t side = padded(width);
  // Columns of L⁻¹, one after another: L x = e_j.
  for (std::size_t j = 0; j < width; ++j) {
    float* x = workspace + j * side;
    std::fill(x, x + side, 0.0f);
    x[j] = 1.0f;
    for (std::size_t k = j; k < width; ++k) {
      const float* column = panel + k * stride;
      x[k] /= column[k];
      subtract(x + k + 1, column + k + 1, x[k], width - k - 1);
    }
  }
  // X L⁻¹, some rows at a time: column j needs those from j on, so that it may take the place of what it came from.
  for (std::size_t i = width; i < rows; i += kWide) {
    const std::size_t bytes = std::min<std::size_t>(kWide, rows - i) * sizeof(float);
    for (std::size_t j = 0; j < width; j += 3) {
      const float *m0 = workspace + j * side, *m1 = m0 + side, *m2 = m1 + side;
      Wide s0{}, s1{}, s2{};
      for (std::size_t k = j; k < width; ++k) {
        const Wide x = load(panel + k * stride + i);
        s0 += x * m0[k], s1 += x * m1[k], s2 += x * m2[k];
      }
      float* at = panel + j * stride + i;
      std::memcpy(at, &s0, bytes), std::memcpy(at + stride, &s1, bytes), std::memcpy(at + 2 * stride, &s2, bytes);
    }
  }
  for (std::size_t j = 0; j < width; ++j)
    std::copy(workspace + j * side, workspace + j * side + width, panel + j * stride);
}

BRIM_WIDE void multiply(const float* panel, std::size_t stride, std::size_t rows, std::size_t width, const float* x,
                        float* y) {
  std::fill(y, y + rows, 0.0f);
  std::size_t k = 0;
  // Rows above k of columns from k on are zero.
  for (; k + 6 <= width; k += 6) {
    const float *c0 = panel + k * stride, *c1 = c0 + stride, *c2 = c1 + stride, *c3 = c2 + stride, *c4 = c3 + stride,
                *c5 = c4 + stride;
    const float x0 = x[k], x1 = x[k + 1], x2 = x[k + 2], x3 = x[k + 3], x4 = x[k + 4], x5 = x[k + 5];
    std::size_t i = k;
    for (; i + kWide <= rows; i += kWide)
      store(y + i, (load(y + i) + load(c0 + i) * x0 + load(c1 + i) * x1) + (load(c2 + i) * x2 + load(c3 + i) * x3) +
                       (load(c4 + i) * x4 + load(c5 + i) * x5));
    for (; i < rows; ++i)
      y[i] = (y[i] + c0[i] * x0 + c1[i] * x1) + (c2[i] * x2 + c3[i] * x3) + (c4[i] * x4 + c5[i] * x5);
  }
  for (; k < width; k += 3) {
    const float *c0 = panel + k * stride, *c1 = c0 + stride, *c2 = c1 + stride;
    const float x0 = x[k], x1 = x[k + 1], x2 = x[k + 2];
    std::size_t i = k;
    for (; i + kWide <= rows; i += kWide)
      store(y + i, (load(y + i) + load(c0 + i) * x0) + (load(c1 + i) * x1 + load(c2 + i) * x2));
    for (; i < rows; ++i) y[i] = (y[i] + c0[i] * x0) + (c1[i] * x1 + c2[i] * x2);
  }
}

BRIM_WIDE void multiply_by_transpose(const float* panel, std::size_t stride, std::size_t rows, std::size_t width,
                                     const float* y, float* x) {
  for (std::size_t k = 0; k < width; k += 3) {
    const float *c0 = panel + k * stride, *c1 = c0 + stride, *c2 = c1 + stride;
    Wide s0{}, s1{}, s2{};
    std::size_t i = k;
    for (; i + kWide <= rows; i += kWide) {
      const Wide v = load(y + i);
      s0 += load(c0 + i) * v, s1 += load(c1 + i) * v, s2 += load(c2 + i) * v;
    }
    float t0 = 0.0f, t1 = 0.0f, t2 = 0.0f;
    for (; i < rows; ++i) t0 += c0[i] * y[i], t1 += c1[i] * y[i], t2 += c2[i] * y[i];
    x[k] = sum_of(s0) + t0, x[k + 1] = sum_of(s1) + t1, x[k + 2] = sum_of(s2) + t2;
  }
}

}  // namespace brim::panel
