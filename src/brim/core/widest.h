#pragma once

#include <cstring>
#include <type_traits>

#include "brim/core/simd.h"

// Kernels that process 64 bytes at a time: in one register of AVX-512 or in two of AVX2. They are templates of one of
// the two types below, since GCC 12 keeps a vector that is longer than the machine's registers in memory, word by word:
// ten times slower.

namespace brim {

/// Two vectors used as one of twice the length.
template <class Half>
struct TwoOf {
  using Number = std::remove_cvref_t<decltype(Half{}[0])>;
  Half low, high;

  friend BRIM_INLINE TwoOf operator+(const TwoOf& a, const TwoOf& b) { return {a.low + b.low, a.high + b.high}; }
  friend BRIM_INLINE TwoOf operator-(const TwoOf& a, const TwoOf& b) { return {a.low - b.low, a.high - b.high}; }
  friend BRIM_INLINE TwoOf operator*(const TwoOf& a, const TwoOf& b) { return {a.low * b.low, a.high * b.high}; }
  friend BRIM_INLINE TwoOf operator+(Number s, const TwoOf& a) { return {s + a.low, s + a.high}; }
  friend BRIM_INLINE TwoOf operator*(Number s, const TwoOf& a) { return {s * a.low, s * a.high}; }
  friend BRIM_INLINE TwoOf operator*(const TwoOf& a, Number s) { return s * a; }
  BRIM_INLINE TwoOf& operator+=(const TwoOf& o) { return *this = *this + o; }
  BRIM_INLINE TwoOf& operator-=(const TwoOf& o) { return *this = *this - o; }
};

/// Numbers of a kernel in one register, where the machine has such.
struct InOne {
  typedef float Floats __attribute__((vector_size(16 * sizeof(float))));
  typedef double Doubles __attribute__((vector_size(8 * sizeof(double))));
};
/// Numbers of a kernel in two registers.
struct InTwo {
  using Floats = TwoOf<WideFloats>;
  using Doubles = TwoOf<Lanes>;
};
inline constexpr int kWidestLanes = 16;
/// Bytes by which a stream is asked for ahead: a machine by itself does not look past a page of 4096.
inline constexpr std::size_t kBytesAhead = 4096;

// Two halves as one, and back.
template <class Widest>
BRIM_INLINE typename Widest::Floats joined(const WideFloats& a, const WideFloats& b) {
  if constexpr (std::is_same_v<Widest, InOne>)
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  else
    return {a, b};
}
BRIM_INLINE WideFloats low_of(const InTwo::Floats& a) { return a.low; }
BRIM_INLINE WideFloats high_of(const InTwo::Floats& a) { return a.high; }
BRIM_INLINE WideFloats low_of(const InOne::Floats& a) { return __builtin_shufflevector(a, a, 0, 1, 2, 3, 4, 5, 6, 7); }
BRIM_INLINE WideFloats high_of(const InOne::Floats& a) {
  return __builtin_shufflevector(a, a, 8, 9, 10, 11, 12, 13, 14, 15);
}

// From memory at any address, and back.
template <class Widest>
BRIM_INLINE typename Widest::Floats load_widest(const float* at) {
  if constexpr (std::is_same_v<Widest, InOne>) {
    InOne::Floats r;
    std::memcpy(&r, at, sizeof r);
    return r;
  } else {
    return {load_wide(at), load_wide(at + kWideLanes)};
  }
}
template <class Widest>
BRIM_INLINE typename Widest::Doubles load_widest(const double* at) {
  if constexpr (std::is_same_v<Widest, InOne>) {
    InOne::Doubles r;
    std::memcpy(&r, at, sizeof r);
    return r;
  } else {
    return {load_lanes(at), load_lanes(at + kLanes)};
  }
}
template <class T, class Half>
BRIM_INLINE void store_lanes(T* at, const TwoOf<Half>& r) {
  store_lanes(at, r.low), store_lanes(at + sizeof(Half) / sizeof(T), r.high);
}

}  // namespace brim

/// Defines a function as BRIM_WIDE does whose body, a call of a template, may use the type Widest: InOne or InTwo. To
/// be used in an unnamed namespace, as other files would always call the version for the base instruction set.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__) && \
    !defined(__SANITIZE_ADDRESS__)
#define BRIM_WIDEST(name, parameters, ...)                                 \
  BRIM_FOR_MACHINE("arch=x86-64-v4", InOne, name, parameters, __VA_ARGS__) \
  BRIM_FOR_MACHINE("avx2", InTwo, name, parameters, __VA_ARGS__)           \
  BRIM_FOR_MACHINE("default", InTwo, name, parameters, __VA_ARGS__)
#define BRIM_FOR_MACHINE(instructions, type, name, parameters, ...) \
  __attribute__((target(instructions))) void name parameters {      \
    using Widest = type;                                            \
    __VA_ARGS__;                                                    \
  }
#else
#define BRIM_WIDEST(name, parameters, ...) \
  void name parameters {                   \
    using Widest = InTwo;                  \
    __VA_ARGS__;                           \
  }
#endif
