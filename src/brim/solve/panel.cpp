#include "brim/solve/panel.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "brim/core/simd.h"

namespace brim::panel {

namespace {

constexpr int kWide = 8;
typedef float Wide __attribute__((vector_size(kWide * sizeof(float))));
typedef std::int32_t WideWord __attribute__((vector_size(kWide * sizeof(std::int32_t))));
/// Steps from zero to the largest number of a column in ten bits.
constexpr std::int32_t kSteps = 511;
/// Makes all of them positive, and a half more.
constexpr float kLift = kSteps + 1.5f;
/// Where the ten bits of a triple's first, second and third number lie in its word.
constexpr int kFirst = 0, kSecond = 11, kThird = 22;
constexpr std::uint32_t kTenBits = 0x3ff;

BRIM_INLINE Wide load(const float* p) {
  Wide w;
  __builtin_memcpy(&w, p, sizeof w);
  return w;
}
BRIM_INLINE WideWord load(const Triple* p) {
  WideWord w;
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

/// Replaces the lower triangle of a small matrix by its Cholesky factor. @return pivots that were lifted
BRIM_INLINE int factor_square(float* L, std::size_t stride, std::size_t n) {
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

/// B := B L⁻ᵀ for the rows below a square of N columns that holds L⁻¹.
template <int N>
BRIM_INLINE void divide(float* square, std::size_t stride, std::size_t rows) {
  const auto combine = [&](auto(&b)[N]) {
    for (int j = N; j-- > 0;) {
      b[j] *= square[static_cast<std::size_t>(j) * stride + static_cast<std::size_t>(j)];
      for (int k = 0; k < j; ++k)
        b[j] += b[k] * square[static_cast<std::size_t>(k) * stride + static_cast<std::size_t>(j)];
    }
  };
  std::size_t i = N;
  for (; i + kWide <= N + rows; i += kWide) {
    Wide b[N];
    for (int k = 0; k < N; ++k) b[k] = load(square + static_cast<std::size_t>(k) * stride + i);
    combine(b);
    for (int k = 0; k < N; ++k) store(square + static_cast<std::size_t>(k) * stride + i, b[k]);
  }
  for (; i < N + rows; ++i) {
    float b[N];
    for (int k = 0; k < N; ++k) b[k] = square[static_cast<std::size_t>(k) * stride + i];
    combine(b);
    for (int k = 0; k < N; ++k) square[static_cast<std::size_t>(k) * stride + i] = b[k];
  }
}

/// Chunks of rows of a stream.
BRIM_INLINE std::size_t chunks(std::size_t rows) { return (rows + kWide - 1) / kWide; }
/// Numbers of T in a chunk of some columns, a multiple of three.
template <class T>
constexpr std::size_t chunk_size(std::size_t columns) {
  return kWide * (std::is_same_v<T, float> ? columns : columns / 3);
}

/// What a number of the stream is worth, of which the column's largest is `most`; and the number for a value. Those of
/// ten bits are read where the highest bits of a word are.
BRIM_INLINE float step_for(float, float) { return 1.0f; }
BRIM_INLINE float step_for(Triple, float most) { return most / (static_cast<float>(1 << kThird) * kSteps); }
BRIM_INLINE float inverse_step(float, float) { return 1.0f; }
BRIM_INLINE float inverse_step(Triple, float most) { return most > 0.0f ? kSteps / most : 0.0f; }
BRIM_INLINE void encode(Wide x, int, float* out) { store(out, x); }
/// Writes the number of a triple that `which` tells; the first one clears the word.
BRIM_INLINE void encode(Wide x, int which, Triple* out) {  // to the nearest: what is cut off here is positive
  const WideWord n = __builtin_convertvector(x + kLift, WideWord) - (kSteps + 1);
  const int shift = which == 0 ? kFirst : which == 1 ? kSecond : kThird;
  WideWord word = which == 0 ? WideWord{} : load(out);
  word |= (n & static_cast<std::int32_t>(kTenBits)) << shift;
  __builtin_memcpy(out, &word, sizeof word);
}

/// Eight rows of three columns.
struct Three {
  Wide column[3];
};
BRIM_INLINE Three decode(const float* stream) {
  return {{load(stream), load(stream + kWide), load(stream + 2 * kWide)}};
}
BRIM_INLINE Three decode(const Triple* stream) {
  constexpr auto kHigh = static_cast<std::int32_t>(kTenBits << kThird);
  const WideWord w = load(stream);
  return {{__builtin_convertvector(w << (kThird - kFirst), Wide),
           __builtin_convertvector((w << (kThird - kSecond)) & kHigh, Wide), __builtin_convertvector(w & kHigh, Wide)}};
}

/// The largest magnitude of some numbers.
BRIM_INLINE float largest(const float* x, std::size_t n) {
  Wide most = {};
  std::size_t i = 0;
  for (; i + kWide <= n; i += kWide) {
    const Wide v = load(x + i), size = v < 0.0f ? -v : v;
    most = size > most ? size : most;
  }
  float m = 0.0f;
  for (int k = 0; k < kWide; ++k) m = std::max(m, most[k]);
  for (; i < n; ++i) m = std::max(m, std::abs(x[i]));
  return m;
}

template <class T>
BRIM_INLINE void to_stream(const float* panel, std::size_t stride, std::size_t rows, std::size_t width,
                           const Stream<T>& out) {
  T* stream = out.below;
  for (std::size_t first = 0; first < width; first += kBlock) {
    const std::size_t block = std::min(kBlock, width - first), end = first + block, n = chunks(rows - end);
    const std::size_t chunk = chunk_size<T>(block);
    std::fill_n(out.column + first * kSquare, block * kSquare, 0.0f);
    std::fill_n(out.row + first * kSquare, block * kSquare, 0.0f);
    for (std::size_t k = 0; k < block; ++k) {
      const float *column = panel + (first + k) * stride, *below = column + end;
      for (std::size_t i = k; i < block; ++i)
        out.column[(first + k) * kSquare + i] = out.row[(first + i) * kSquare + k] = column[first + i];
      const float most = largest(below, rows - end);
      out.step[first + k] = step_for(T{}, most);
      const float inverse = inverse_step(T{}, most);
      const std::size_t full = (rows - end) / kWide, rest = (rows - end) % kWide;
      T* at = stream + (std::is_same_v<T, float> ? k : k / 3) * kWide;
      const int which = static_cast<int>(k % 3);
      for (std::size_t c = 0; c < full; ++c) encode(load(below + c * kWide) * inverse, which, at + c * chunk);
      if (rest == 0) continue;
      float last[kWide] = {};
      std::copy_n(below + full * kWide, rest, last);
      encode(load(last) * inverse, which, at + full * chunk);
    }
    stream += n * chunk;
  }
}

/// x = Σ_k s_k v_k for the columns or rows s of a square with N of them; what is beyond N is zero.
template <int N>
BRIM_INLINE void square_product(const float* s, const float* v, float (&x)[kSquare]) {
  Wide low = {}, high = {};
  for (int k = 0; k < N; ++k, s += kSquare) {
    low += load(s) * v[k];
    if (N > kWide) high += load(s + kWide) * v[k];
  }
  store(x, low), store(x + kWide, high);
}

/// y -= B x, B the N columns of a block as a stream.
template <int N, class T>
BRIM_INLINE void subtract_product(const T* stream, const float* x, std::size_t n, float* y) {
  for (std::size_t c = 0; c < n; ++c, y += kWide) {
    Wide sum[3];
    for (int k = 0; k < N; k += 3, stream += chunk_size<T>(3)) {
      const Three b = decode(stream);
      for (int i = 0; i < 3; ++i) sum[i] = k == 0 ? b.column[i] * x[i] : sum[i] + b.column[i] * x[k + i];
    }
    store(y, load(y) - ((sum[0] + sum[1]) + sum[2]));
  }
}

/// t = Bᵀ y
template <int N, class T>
BRIM_INLINE void transposed_product(const T* stream, const float* y, std::size_t n, float* t) {
  Wide sum[N] = {};
  for (std::size_t c = 0; c < n; ++c, y += kWide) {
    const Wide v = load(y);
    for (int k = 0; k < N; k += 3, stream += chunk_size<T>(3)) {
      const Three b = decode(stream);
      for (int i = 0; i < 3; ++i) sum[k + i] += b.column[i] * v;
    }
  }
  for (int k = 0; k < N; ++k) t[k] = sum_of(sum[k]);
}

template <int N, class T>
BRIM_INLINE void forward_block(const Stream<T>& panel, const T* stream, std::size_t first, std::size_t n, float* y) {
  float x[kSquare];
  square_product<N>(panel.column + first * kSquare, y + first, x);
  std::copy_n(x, N, y + first);
  for (int k = 0; k < N; ++k) x[k] *= panel.step[first + static_cast<std::size_t>(k)];
  subtract_product<N>(stream, x, n, y + first + N);
}

template <int N, class T>
BRIM_INLINE void backward_block(const Stream<T>& panel, const T* stream, std::size_t first, std::size_t n, float* y) {
  float t[N], x[kSquare];
  transposed_product<N>(stream, y + first + N, n, t);
  for (int k = 0; k < N; ++k)
    t[k] = y[first + static_cast<std::size_t>(k)] - panel.step[first + static_cast<std::size_t>(k)] * t[k];
  square_product<N>(panel.row + first * kSquare, t, x);
  std::copy_n(x, N, y + first);
}

template <class T>
BRIM_INLINE void forward(const Stream<T>& panel, std::size_t rows, std::size_t width, float* y) {
  const T* stream = panel.below;
  for (std::size_t first = 0; first < width; first += kBlock) {
    const std::size_t block = std::min(kBlock, width - first), n = chunks(rows - first - block);
    switch (block) {
      case 3:
        forward_block<3>(panel, stream, first, n, y);
        break;
      case 6:
        forward_block<6>(panel, stream, first, n, y);
        break;
      case 9:
        forward_block<9>(panel, stream, first, n, y);
        break;
      default:
        forward_block<12>(panel, stream, first, n, y);
    }
    stream += n * chunk_size<T>(block);
  }
}

template <class T>
BRIM_INLINE void backward(const Stream<T>& panel, std::size_t rows, std::size_t width, float* y) {
  const T* stream = panel.below + stream_size<T>(rows, width);
  for (std::size_t first = (width - 1) / kBlock * kBlock;; first -= kBlock) {
    const std::size_t block = std::min(kBlock, width - first), n = chunks(rows - first - block);
    stream -= n * chunk_size<T>(block);
    switch (block) {
      case 3:
        backward_block<3>(panel, stream, first, n, y);
        break;
      case 6:
        backward_block<6>(panel, stream, first, n, y);
        break;
      case 9:
        backward_block<9>(panel, stream, first, n, y);
        break;
      default:
        backward_block<12>(panel, stream, first, n, y);
    }
    if (first == 0) break;
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
    const std::size_t block = std::min(kBlock, width - first), end = first + block;
    if (first > 0) {
      // What the columns before take from this block.
      const std::size_t n = rows - first, out = padded(n);
      multiply_transposed(panel + first, panel + first, stride, n, block, first, workspace);
      for (std::size_t j = 0; j < block; ++j)
        subtract(panel + (first + j) * stride + first, workspace + j * out, 1.0f, n);
    }
    float* square = panel + first * stride + first;
    lifted += factor_square(square, stride, block);
    invert_triangle(square, stride, block);
    switch (block) {
      case 3:
        divide<3>(square, stride, rows - end);
        break;
      case 6:
        divide<6>(square, stride, rows - end);
        break;
      case 9:
        divide<9>(square, stride, rows - end);
        break;
      default:
        divide<12>(square, stride, rows - end);
    }
  }
  return lifted;
}

template <class T>
std::size_t stream_size(std::size_t rows, std::size_t width) {
  std::size_t sum = 0;
  for (std::size_t first = 0; first < width; first += kBlock) {
    const std::size_t end = std::min(first + kBlock, width);
    sum += chunks(rows - end) * chunk_size<T>(end - first);
  }
  return sum;
}

template std::size_t stream_size<float>(std::size_t rows, std::size_t width);
template std::size_t stream_size<Triple>(std::size_t rows, std::size_t width);

BRIM_WIDE void make_stream(const float* panel, std::size_t stride, std::size_t rows, std::size_t width,
                           const Stream<float>& out) {
  to_stream(panel, stride, rows, width, out);
}
BRIM_WIDE void make_stream(const float* panel, std::size_t stride, std::size_t rows, std::size_t width,
                           const Stream<Triple>& out) {
  to_stream(panel, stride, rows, width, out);
}
BRIM_WIDE void solve_forward(const Stream<float>& panel, std::size_t rows, std::size_t width, float* y) {
  forward(panel, rows, width, y);
}
BRIM_WIDE void solve_forward(const Stream<Triple>& panel, std::size_t rows, std::size_t width, float* y) {
  forward(panel, rows, width, y);
}
BRIM_WIDE void solve_backward(const Stream<float>& panel, std::size_t rows, std::size_t width, float* y) {
  backward(panel, rows, width, y);
}
BRIM_WIDE void solve_backward(const Stream<Triple>& panel, std::size_t rows, std::size_t width, float* y) {
  backward(panel, rows, width, y);
}

}  // namespace brim::panel
