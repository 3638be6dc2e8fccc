#pragma once

#include <cstdint>

namespace brim {

/// Step of the state of splitmix64.
inline constexpr std::uint64_t kSplitmixStep = 0x9e3779b97f4a7c15u;

/// A number scattered over all 64 bits, no two alike: the output of splitmix64 in state i (Steele, Lea and Flood, Fast
/// splittable pseudorandom number generators, 2014). The same on every machine, unlike the standard distributions.
/// Tests: tests/math/splitmix_test.cpp
constexpr std::uint64_t scattered(std::uint64_t i) {
  i += kSplitmixStep;
  i = (i ^ (i >> 30)) * 0xbf58476d1ce4e5b9u;
  i = (i ^ (i >> 27)) * 0x94d049bb133111ebu;
  return i ^ (i >> 31);
}

/// The next output of splitmix64. @param state  the seed at first
constexpr std::uint64_t next_scattered(std::uint64_t& state) {
  const std::uint64_t z = scattered(state);
  state += kSplitmixStep;
  return z;
}

}  // namespace brim
