#include "brim/solve/panel.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

BRIM_WIDE void multiply_transposed(const float* a, const float* b, std::size_t stride, std::size_t rows,
                                   std::size_t columns, std::size_t depth, float* c) {
  const std::size_t out = padded(rows);
  for (std::size_t i = 0; i < rows; i += 2 * kWide) {
    std::size_t j = 0;
    for (; j + 6 <= columns; j += 6) {
      Wide s00{}, s01{}, s02{}, s03{}, s04{}, s05{}, s10{}, s11{}, s12{}, s13{}, s14{}, s15{};
      const float *ak = a + i, *bk = b + j;
      for (std::size_t k = 0; k < depth; ++k, ak += stride, bk += stride) {
        const Wide x0 = load(ak), x1 = load(ak + kWide);
        s00 += x0 * bk[0], s10 += x1 * bk[0];
        s01 += x0 * bk[1], s11 += x1 * bk[1];
        s02 += x0 * bk[2], s12 += x1 * bk[2];
        s03 += x0 * bk[3], s13 += x1 * bk[3];
        s04 += x0 * bk[4], s14 += x1 * bk[4];
        s05 += x0 * bk[5], s15 += x1 * bk[5];
      }
      float* ci = c + j * out + i;
      store(ci, s00), store(ci + kWide, s10), ci += out;
      store(ci, s01), store(ci + kWide, s11), ci += out;
      store(ci, s02), store(ci + kWide, s12), ci += out;
      store(ci, s03), store(ci + kWide, s13), ci += out;
      store(ci, s04), store(ci + kWide, s14), ci += out;
      store(ci, s05), store(ci + kWide, s15);
    }
    for (; j < columns; j += 3) {
      Wide s00{}, s01{}, s02{}, s10{}, s11{}, s12{};
      const float *ak = a + i, *bk = b + j;
      for (std::size_t k = 0; k < depth; ++k, ak += stride, bk += stride) {
        const Wide x0 = load(ak), x1 = load(ak + kWide);
        s00 += x0 * bk[0], s10 += x1 * bk[0];
        s01 += x0 * bk[1], s11 += x1 * bk[1];
        s02 += x0 * bk[2], s12 += x1 * bk[2];
      }
      float* ci = c + j * out + i;
      store(ci, s00), store(ci + kWide, s10), ci += out;
      store(ci, s01), store(ci + kWide, s11), ci += out;
      store(ci, s02), store(ci + kWide, s12);
    }
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
  for (std::size_t first = 0; first < width; first += kBlock)
    invert_triangle(panel + first * stride + first, stride, std::min(kBlock, width - first));
  return lifted;
}

BRIM_WIDE void solve_forward(const float* panel, std::size_t stride, std::size_t rows, std::size_t width, float* y) {
  for (std::size_t first = 0; first < width; first += kBlock) {
    const std::size_t block = std::min(kBlock, width - first), end = first + block;
    float x[kBlock] = {};
    for (std::size_t k = 0; k < block; ++k) {
      const float* column = panel + (first + k) * stride + first;
      for (std::size_t i = k; i < block; ++i) x[i] += column[i] * y[first + k];
    }
    std::copy(x, x + block, y + first);
    for (std::size_t k = 0; k < block; k += 3) {
      const float *c0 = panel + (first + k) * stride, *c1 = c0 + stride, *c2 = c1 + stride;
      const float x0 = x[k], x1 = x[k + 1], x2 = x[k + 2];
      std::size_t i = end;
      for (; i + kWide <= rows; i += kWide)
        store(y + i, (load(y + i) - load(c0 + i) * x0) - (load(c1 + i) * x1 + load(c2 + i) * x2));
      for (; i < rows; ++i) y[i] = (y[i] - c0[i] * x0) - (c1[i] * x1 + c2[i] * x2);
    }
  }
}

BRIM_WIDE void solve_backward(const float* panel, std::size_t stride, std::size_t rows, std::size_t width, float* y) {
  for (std::size_t first = (width - 1) / kBlock * kBlock;; first -= kBlock) {
    const std::size_t block = std::min(kBlock, width - first), end = first + block;
    float t[kBlock];
    for (std::size_t k = 0; k < block; k += 3) {
      const float *c0 = panel + (first + k) * stride, *c1 = c0 + stride, *c2 = c1 + stride;
      Wide s0{}, s1{}, s2{};
      std::size_t i = end;
      for (; i + kWide <= rows; i += kWide) {
        const Wide v = load(y + i);
        s0 += load(c0 + i) * v, s1 += load(c1 + i) * v, s2 += load(c2 + i) * v;
      }
      float t0 = 0.0f, t1 = 0.0f, t2 = 0.0f;
      for (; i < rows; ++i) t0 += c0[i] * y[i], t1 += c1[i] * y[i], t2 += c2[i] * y[i];
      t[k] = y[first + k] - (sum_of(s0) + t0);
      t[k + 1] = y[first + k + 1] - (sum_of(s1) + t1);
      t[k + 2] = y[first + k + 2] - (sum_of(s2) + t2);
    }
    for (std::size_t k = 0; k < block; ++k) {
      const float* column = panel + (first + k) * stride + first;
      float sum = 0.0f;
      for (std::size_t i = k; i < block; ++i) sum += column[i] * t[i];
      y[first + k] = sum;
    }
    if (first == 0) break;
  }
}

}  // namespace brim::panel
