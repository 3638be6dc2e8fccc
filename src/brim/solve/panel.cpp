#include "brim/solve/panel.h"

#include <algorithm>
#include <cmath>

#include "brim/core/wide.h"

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

/// Σ x[i] y[i] in lanes that do not depend on the machine.
BRIM_INLINE float dot(const float* x, const float* y, std::size_t n) {
  Wide sum{};
  std::size_t i = 0;
  for (; i + kWide <= n; i += kWide) sum += load(x + i) * load(y + i);
  float tail = 0.0f;
  for (; i < n; ++i) tail += x[i] * y[i];
  return (((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]))) + tail;
}

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

BRIM_WIDE void solve_forward(const float* panel, std::size_t stride, std::size_t rows, std::size_t width, float* x,
                             float* below) {
  const std::size_t n = rows - width;
  std::fill(below, below + n, 0.0f);
  for (std::size_t k = 0; k < width; ++k) {
    const float* column = panel + k * stride;
    const float xk = x[k] / column[k];
    x[k] = xk;
    subtract(x + k + 1, column + k + 1, xk, width - k - 1);
  }
  std::size_t k = 0;
  for (; k + 3 <= width; k += 3) {
    const float *c0 = panel + k * stride + width, *c1 = c0 + stride, *c2 = c1 + stride;
    const float x0 = x[k], x1 = x[k + 1], x2 = x[k + 2];
    for (std::size_t i = 0; i < n; ++i) below[i] += c0[i] * x0 + c1[i] * x1 + c2[i] * x2;
  }
}

BRIM_WIDE void solve_backward(const float* panel, std::size_t stride, std::size_t rows, std::size_t width, float* x,
                              const float* below) {
  const std::size_t n = rows - width;
  for (std::size_t k = width; k-- > 0;) {
    const float* column = panel + k * stride;
    const float sum = dot(column + width, below, n) + dot(column + k + 1, x + k + 1, width - k - 1);
    x[k] = (x[k] - sum) / column[k];
  }
}

}  // namespace brim::panel
