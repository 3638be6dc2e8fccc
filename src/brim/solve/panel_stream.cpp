#include "brim/solve/panel_stream.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "brim/core/widest.h"

namespace brim::panel {

namespace {

/// Blocks of a stream whose squares are asked for before they are used.
constexpr std::ptrdiff_t kAhead = 2;
constexpr std::size_t kLine = 64;

/// Asks for n numbers from a place on, which need not be there.
template <class T>
BRIM_INLINE void ask_for(const T* at, std::size_t n) {
  const char* byte = reinterpret_cast<const char*>(at);
  for (std::size_t l = 0; l < n * sizeof(T); l += kLine) __builtin_prefetch(byte + l);
}
/// Steps from zero to the largest number of a column in ten bits.
constexpr std::int32_t kSteps = 511;
/// Makes all of them positive, and a half more.
constexpr float kLift = kSteps + 1.5f;
/// Where the ten bits of a triple's first, second and third number lie in its word.
constexpr int kFirst = 0, kSecond = 11, kThird = 22;
constexpr std::uint32_t kTenBits = 0x3ff;

BRIM_INLINE WideIds load(const Triple* p) {
  WideIds w;
  std::memcpy(&w, p, sizeof w);
  return w;
}

/// The sums of the lanes of N vectors, N a multiple of three, each in an order that does not depend on the machine:
/// ((s0 + s4) + (s1 + s5)) + ((s2 + s6) + (s3 + s7)).
template <int N>
BRIM_INLINE void sums_of(const WideFloats (&s)[N], float (&t)[kBlock]) {
  const auto half = [&](int k) {
    const WideFloats v = k < N ? s[k] : WideFloats{};
    return FloatLanes(__builtin_shufflevector(v, v, 0, 1, 2, 3) + __builtin_shufflevector(v, v, 4, 5, 6, 7));
  };
#pragma GCC unroll 3
  for (int k = 0; k < N; k += 4) {
    const FloatLanes a = half(k), b = half(k + 1), c = half(k + 2), d = half(k + 3);
    const FloatLanes ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
    const FloatLanes AB = __builtin_shufflevector(a, b, 2, 6, 3, 7), CD = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    const FloatLanes sum = (__builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7)) +
                           (__builtin_shufflevector(AB, CD, 0, 1, 4, 5) + __builtin_shufflevector(AB, CD, 2, 3, 6, 7));
    store_lanes(t + k, sum);
  }
}

/// Chunks of rows of a stream.
BRIM_INLINE std::size_t chunks(std::size_t rows) { return (rows + kWideLanes - 1) / kWideLanes; }
/// Numbers of T in a chunk of some columns, a multiple of three.
template <class T>
constexpr std::size_t chunk_size(std::size_t columns) {
  return kWideLanes * (std::is_same_v<T, float> ? columns : columns / 3);
}

/// What a number of the stream is worth, of which the column's largest is `most`; and the number for a value. Those of
/// ten bits are read where the highest bits of a word are.
BRIM_INLINE float step_for(float, float) { return 1.0f; }
BRIM_INLINE float step_for(Triple, float most) { return most / (static_cast<float>(1 << kThird) * kSteps); }
BRIM_INLINE float inverse_step(float, float) { return 1.0f; }
BRIM_INLINE float inverse_step(Triple, float most) { return most > 0.0f ? kSteps / most : 0.0f; }
BRIM_INLINE void encode(const WideFloats& x, int, float* out) { store_wide(x, out); }
/// Writes the number of a triple that `which` tells; the first one clears the word.
BRIM_INLINE void encode(const WideFloats& x, int which,
                        Triple* out) {  // to the nearest: what is cut off here is positive
  const WideIds n = __builtin_convertvector(x + kLift, WideIds) - (kSteps + 1);
  const int shift = which == 0 ? kFirst : which == 1 ? kSecond : kThird;
  WideIds word = which == 0 ? WideIds{} : load(out);
  word |= (n & static_cast<std::int32_t>(kTenBits)) << shift;
  __builtin_memcpy(out, &word, sizeof word);
}

/// Eight rows of three columns.
struct Three {
  WideFloats column[3];
};
BRIM_INLINE Three decode(const float* stream) {
  return {{load_wide(stream), load_wide(stream + kWideLanes), load_wide(stream + 2 * kWideLanes)}};
}
BRIM_INLINE Three decode(const Triple* stream) {
  constexpr auto kHigh = static_cast<std::int32_t>(kTenBits << kThird);
  const WideIds w = load(stream);
  return {{__builtin_convertvector(w << (kThird - kFirst), WideFloats),
           __builtin_convertvector((w << (kThird - kSecond)) & kHigh, WideFloats),
           __builtin_convertvector(w & kHigh, WideFloats)}};
}

/// Sixteen rows of three columns: those of two chunks that follow one another.
template <class Widest>
struct WideThree {
  typename Widest::Floats column[3];
};
template <class Widest, class T>
BRIM_INLINE WideThree<Widest> decode_two(const T* stream, const T* next) {
  const Three a = decode(stream), b = decode(next);
  WideThree<Widest> r;
  for (int i = 0; i < 3; ++i) r.column[i] = joined<Widest>(a.column[i], b.column[i]);
  return r;
}

/// The largest magnitude of some numbers.
BRIM_INLINE float largest(const float* x, std::size_t n) {
  WideFloats most = {};
  std::size_t i = 0;
  for (; i + kWideLanes <= n; i += kWideLanes) {
    const WideFloats v = load_wide(x + i), size = v < 0.0f ? -v : v;
    most = size > most ? size : most;
  }
  float m = 0.0f;
  for (int k = 0; k < kWideLanes; ++k) m = std::max(m, most[k]);
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
      const std::size_t full = (rows - end) / kWideLanes, rest = (rows - end) % kWideLanes;
      T* at = stream + (std::is_same_v<T, float> ? k : k / 3) * kWideLanes;
      const int which = static_cast<int>(k % 3);
      for (std::size_t c = 0; c < full; ++c) encode(load_wide(below + c * kWideLanes) * inverse, which, at + c * chunk);
      if (rest == 0) continue;
      float last[kWideLanes] = {};
      std::copy_n(below + full * kWideLanes, rest, last);
      encode(load_wide(last) * inverse, which, at + full * chunk);
    }
    stream += n * chunk;
  }
}

/// x = Σ_k s_k v_k for the columns or rows s of a square with N of them; what is beyond N is zero.
template <int N>
BRIM_INLINE void square_product(const float* s, const float* v, float (&x)[2 * kWideLanes]) {
  WideFloats low = {}, high = {};
  for (int k = 0; k < N; ++k, s += kSquare) {
    low += load_wide(s) * v[k];
    if (N > kWideLanes) high += load_wide(s + kWideLanes) * v[k];
  }
  store_wide(low, x), store_wide(high, x + kWideLanes);
}

/// y -= B x, B the N columns of a block as a stream.
template <class Widest, int N, class T>
BRIM_INLINE void subtract_product(const T* stream, const float* x, std::size_t n, float* y) {
  const auto sum_of = [x](const auto& of) BRIM_LAMBDA_INLINE {
    auto b = of(0);
    auto s0 = b.column[0] * x[0], s1 = b.column[1] * x[1], s2 = b.column[2] * x[2];
    for (int k = 3; k < N; k += 3) {
      b = of(k);
      s0 += b.column[0] * x[k], s1 += b.column[1] * x[k + 1], s2 += b.column[2] * x[k + 2];
    }
    return (s0 + s1) + s2;
  };
  constexpr std::size_t kChunk = chunk_size<T>(N);
  for (; n >= 2; n -= 2, y += kWidestLanes, stream += 2 * kChunk) {
    const auto two = [stream](int k) BRIM_LAMBDA_INLINE {
      const T* at = stream + chunk_size<T>(static_cast<std::size_t>(k));
      return decode_two<Widest>(at, at + kChunk);
    };
    ask_for(stream + kBytesAhead / sizeof(T), 2 * kChunk);
    store_lanes(y, typename Widest::Floats(load_widest<Widest>(y) - sum_of(two)));
  }
  if (n == 0) return;
  const auto one = [stream](int k)
                       BRIM_LAMBDA_INLINE { return decode(stream + chunk_size<T>(static_cast<std::size_t>(k))); };
  store_wide(load_wide(y) - sum_of(one), y);
}

/// t = Bᵀ y
template <int N, class T>
BRIM_INLINE void transposed_product(const T* stream, const float* y, std::size_t n, float (&t)[kBlock]) {
  WideFloats sum[N] = {};
  const std::size_t before = n * chunk_size<T>(N);  // what follows lies before it in memory
  for (std::size_t c = 0; c < n; ++c, y += kWideLanes) {
    const WideFloats v = load_wide(y);
    ask_for(stream - before, chunk_size<T>(N));
    for (int k = 0; k < N; k += 3, stream += chunk_size<T>(3)) {
      const Three b = decode(stream);
      for (int i = 0; i < 3; ++i) sum[k + i] += b.column[i] * v;
    }
  }
  sums_of<N>(sum, t);
}

/// Squares are read one after another, some blocks apart in time: too far for a machine to see that they follow.
/// Asks for that of another block. @param blocks  how far it is
BRIM_INLINE void ask_for_square(const float* square, std::ptrdiff_t blocks) {
  constexpr std::ptrdiff_t kSize = kBlock * kSquare;
  ask_for(square + blocks * kSize, kSize);
}

template <class Widest, int N, class T>
BRIM_INLINE void forward_block(const Stream<T>& panel, const T* stream, std::size_t first, std::size_t n, float* y) {
  float x[2 * kWideLanes];
  ask_for_square(panel.column + first * kSquare, kAhead);
  square_product<N>(panel.column + first * kSquare, y + first, x);
  std::copy_n(x, N, y + first);
  for (int k = 0; k < N; ++k) x[k] *= panel.step[first + static_cast<std::size_t>(k)];
  subtract_product<Widest, N>(stream, x, n, y + first + N);
}

template <int N, class T>
BRIM_INLINE void backward_block(const Stream<T>& panel, const T* stream, std::size_t first, std::size_t n, float* y) {
  float t[kBlock], x[2 * kWideLanes];
  ask_for_square(panel.row + first * kSquare, -kAhead);
  transposed_product<N>(stream, y + first + N, n, t);
  for (int k = 0; k < N; ++k)
    t[k] = y[first + static_cast<std::size_t>(k)] - panel.step[first + static_cast<std::size_t>(k)] * t[k];
  square_product<N>(panel.row + first * kSquare, t, x);
  std::copy_n(x, N, y + first);
}

template <class Widest, class T>
BRIM_INLINE void forward(const Stream<T>& panel, std::size_t rows, std::size_t width, float* y) {
  const T* stream = panel.below;
  for (std::size_t first = 0; first < width; first += kBlock) {
    const std::size_t block = std::min(kBlock, width - first), n = chunks(rows - first - block);
    switch (block) {
      case 3:
        forward_block<Widest, 3>(panel, stream, first, n, y);
        break;
      case 6:
        forward_block<Widest, 6>(panel, stream, first, n, y);
        break;
      case 9:
        forward_block<Widest, 9>(panel, stream, first, n, y);
        break;
      default:
        forward_block<Widest, 12>(panel, stream, first, n, y);
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

BRIM_WIDEST(solve_floats, (const Stream<float>& panel, std::size_t rows, std::size_t width, float* y),
            forward<Widest>(panel, rows, width, y))
BRIM_WIDEST(solve_triples, (const Stream<Triple>& panel, std::size_t rows, std::size_t width, float* y),
            forward<Widest>(panel, rows, width, y))

}  // namespace

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
void solve_forward(const Stream<float>& panel, std::size_t rows, std::size_t width, float* y) {
  solve_floats(panel, rows, width, y);
}
void solve_forward(const Stream<Triple>& panel, std::size_t rows, std::size_t width, float* y) {
  solve_triples(panel, rows, width, y);
}
BRIM_WIDE void solve_backward(const Stream<float>& panel, std::size_t rows, std::size_t width, float* y) {
  backward(panel, rows, width, y);
}
BRIM_WIDE void solve_backward(const Stream<Triple>& panel, std::size_t rows, std::size_t width, float* y) {
  backward(panel, rows, width, y);
}

}  // namespace brim::panel
