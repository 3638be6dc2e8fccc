#include "brim/math/block_rows.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define BRIM_WIDE_ROWS
#include <immintrin.h>
#endif

namespace brim::detail {

void multiply_rows(const BlockRows& K, std::size_t begin, std::size_t end, double a, double b, const double* m,
                   const double* x, double* y) {
  for (std::size_t r = begin; r < end; ++r) {
    double s[3][3];
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k) s[c][k] = K.on_diagonal[r](k, c) * x[3 * r + static_cast<std::size_t>(c)];
    for (std::int32_t slot = K.first[r]; slot < K.first[r + 1]; ++slot) {
      if (slot == K.diagonal[r]) continue;
      const float* B = K.value + 9 * static_cast<std::size_t>(slot);
      const double* xs = x + 3 * static_cast<std::size_t>(K.column[slot]);
      for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k) s[c][k] += static_cast<double>(B[3 * c + k]) * xs[c];
    }
    const double bm = b * m[r];
    for (int k = 0; k < 3; ++k) {
      const std::size_t i = 3 * r + static_cast<std::size_t>(k);
      y[i] += a * ((s[0][k] + s[1][k]) + s[2][k]) + bm * x[i];
    }
  }
}

#ifdef BRIM_WIDE_ROWS

namespace {

/// [floats] by which values are asked for ahead, 128 blocks: the product waits for memory, and a machine by itself does
/// not look past a page.
constexpr std::size_t kAhead = 1152;

/// Adds slots [from, to) to the sums of one row; the fourth lane is not used.
__attribute__((target("avx2"), always_inline)) inline void add_slots(const BlockRows& K, std::int32_t from,
                                                                     std::int32_t to, const double* x, __m256d s[3]) {
  const float* B = K.value + 9 * static_cast<std::size_t>(from);
  for (std::int32_t slot = from; slot < to; ++slot, B += 9) {
    const double* xs = x + 3 * static_cast<std::size_t>(K.column[slot]);
    _mm_prefetch(reinterpret_cast<const char*>(B + kAhead), _MM_HINT_T0);
    for (int c = 0; c < 3; ++c)
      s[c] = _mm256_add_pd(s[c], _mm256_mul_pd(_mm256_cvtps_pd(_mm_loadu_ps(B + 3 * c)), _mm256_broadcast_sd(xs + c)));
  }
}

}  // namespace

__attribute__((target("avx2"))) void multiply_rows_wide(const BlockRows& K, std::size_t begin, std::size_t end,
                                                        double a, double b, const double* m, const double* x,
                                                        double* y) {
  for (std::size_t r = begin; r < end; ++r) {
    const double* D = K.on_diagonal[r].data();
    __m256d s[3];
    for (int c = 0; c < 3; ++c)
      s[c] =
          _mm256_mul_pd(_mm256_set_pd(0.0, D[3 * c + 2], D[3 * c + 1], D[3 * c]), _mm256_broadcast_sd(x + 3 * r + c));
    add_slots(K, K.first[r], K.diagonal[r], x, s);
    add_slots(K, K.diagonal[r] + 1, K.first[r + 1], x, s);
    double sum[4];
    _mm256_storeu_pd(sum, _mm256_mul_pd(_mm256_set1_pd(a), _mm256_add_pd(_mm256_add_pd(s[0], s[1]), s[2])));
    const double bm = b * m[r];
    for (std::size_t k = 0; k < 3; ++k) y[3 * r + k] += sum[k] + bm * x[3 * r + k];
  }
}

bool has_wide_rows() { return __builtin_cpu_supports("avx2") != 0; }

#else

void multiply_rows_wide(const BlockRows& K, std::size_t begin, std::size_t end, double a, double b, const double* m,
                        const double* x, double* y) {
  multiply_rows(K, begin, end, a, b, m, x, y);
}

bool has_wide_rows() { return false; }

#endif

}  // namespace brim::detail
