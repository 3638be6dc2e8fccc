#pragma once

#include <cstdint>
#include <cstring>

// Functions marked BRIM_WIDE are compiled for AVX-512, for AVX2 and for the base instruction set; the version is chosen
// at start-up. Without contraction to fused operations all versions give the same bits. Sanitizers do not support this
// choice. Functions called from a BRIM_WIDE function must be inlined.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define BRIM_WIDE __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define BRIM_WIDE
#endif
#define BRIM_INLINE __attribute__((always_inline)) inline
/// For a lambda that is called in a BRIM_WIDE function.
#define BRIM_LAMBDA_INLINE __attribute__((always_inline))
// Vectors of doubles do not leave a file, so the calling convention of machines without such registers does not matter.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace brim {

inline constexpr int kLanes = 4;
/// Four numbers processed together; the compiler maps them to the machine's registers, with the same bits.
typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));
typedef float FloatLanes __attribute__((vector_size(kLanes * sizeof(float))));
typedef std::int64_t LaneFlags __attribute__((vector_size(kLanes * sizeof(double))));
typedef std::int32_t LaneIds __attribute__((vector_size(kLanes * sizeof(std::int32_t))));

/// Eight numbers in single precision: as wide as Lanes. For more at once see core/widest.h.
inline constexpr int kWideLanes = 8;
typedef float WideFloats __attribute__((vector_size(kWideLanes * sizeof(float))));
typedef std::int32_t WideIds __attribute__((vector_size(kWideLanes * sizeof(std::int32_t))));

BRIM_INLINE WideFloats load_wide(const float* at) {
  WideFloats r;
  std::memcpy(&r, at, sizeof r);
  return r;
}
BRIM_INLINE WideIds load_wide(const std::int32_t* at) {
  WideIds r;
  std::memcpy(&r, at, sizeof r);
  return r;
}
BRIM_INLINE void store_wide(const WideFloats& r, float* at) { std::memcpy(at, &r, sizeof r); }
BRIM_INLINE void store_wide(const WideIds& r, std::int32_t* at) { std::memcpy(at, &r, sizeof r); }

/// Bit l of the result is set where flag l is −1 and clear where it is 0.
BRIM_INLINE std::uint8_t bits_of(const WideIds& flags) {
  const WideIds bit = flags & WideIds{1, 2, 4, 8, 16, 32, 64, 128};
  LaneIds all = __builtin_shufflevector(bit, bit, 0, 1, 2, 3) | __builtin_shufflevector(bit, bit, 4, 5, 6, 7);
  all |= __builtin_shufflevector(all, all, 2, 3, 0, 1);
  all |= __builtin_shufflevector(all, all, 1, 0, 3, 2);
  return static_cast<std::uint8_t>(all[0]);
}

/// Four numbers from memory at any address, and back.
BRIM_INLINE Lanes load_lanes(const double* at) {
  Lanes r;
  std::memcpy(&r, at, sizeof r);
  return r;
}
BRIM_INLINE FloatLanes load_lanes(const float* at) {
  FloatLanes r;
  std::memcpy(&r, at, sizeof r);
  return r;
}
template <class T, class L>
BRIM_INLINE void store_lanes(T* at, const L& lanes) {
  std::memcpy(at, &lanes, sizeof lanes);
}
BRIM_INLINE FloatLanes to_float(const Lanes& d) { return __builtin_convertvector(d, FloatLanes); }
BRIM_INLINE Lanes to_double(const FloatLanes& f) { return __builtin_convertvector(f, Lanes); }

}  // namespace brim
