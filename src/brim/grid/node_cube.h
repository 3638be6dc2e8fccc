#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "brim/math/types.h"

namespace brim {

/// Nodes per side of a cube: one row is one wide register of floats. The inner 6x6x6 nodes are the cube's own; the ring
/// around them serves the 3x3x3 stencils.
inline constexpr int kCubeSize = 8;
inline constexpr int kCubeOwn = kCubeSize - 2;
inline constexpr int kCubeNodes = kCubeSize * kCubeSize * kCubeSize;

/// A row of a cube; the compiler maps it to the machine's registers, with the same bits.
typedef float CubeRow __attribute__((vector_size(kCubeSize * sizeof(float))));
typedef std::int32_t CubeRowFlags __attribute__((vector_size(kCubeSize * sizeof(std::int32_t))));

/// Cube whose node (i, j, k) sits at h (first + (i, j, k)). Arrays over its nodes store that node at i + 8 j + 64 k.
struct NodeCube {
  Vec3i first = Vec3i::Zero();
  double h = 0.0;  ///< [m]
  Vec3 origin() const { return h * first.cast<double>(); }
};
inline constexpr int cube_index(int i, int j, int k) { return i + kCubeSize * (j + kCubeSize * k); }

/// A set of the nodes of a cube: bit i + 8 j of plane k.
struct NodeMask {
  std::array<std::uint64_t, kCubeSize> plane{};

  /// The nodes lo <= (i, j, k) <= hi.
  static NodeMask box(const Vec3i& lo, const Vec3i& hi) {
    const std::uint64_t row = (0xffu >> (7 - hi.x() + lo.x())) << lo.x();
    std::uint64_t layer = 0;
    for (int j = lo.y(); j <= hi.y(); ++j) layer |= row << (8 * j);
    NodeMask m;
    for (int k = lo.z(); k <= hi.z(); ++k) m.plane[k] = layer;
    return m;
  }
  bool any() const {
    std::uint64_t all = 0;
    for (const std::uint64_t p : plane) all |= p;
    return all != 0;
  }
  int count() const {
    int n = 0;
    for (const std::uint64_t p : plane) n += std::popcount(p);
    return n;
  }
  std::uint8_t row(int j, int k) const { return static_cast<std::uint8_t>(plane[k] >> (8 * j)); }
  void set_row(int j, int k, std::uint8_t bits) { plane[k] |= std::uint64_t{bits} << (8 * j); }
  NodeMask& operator|=(const NodeMask& o) {
    for (int k = 0; k < kCubeSize; ++k) plane[k] |= o.plane[k];
    return *this;
  }
  NodeMask& operator&=(const NodeMask& o) {
    for (int k = 0; k < kCubeSize; ++k) plane[k] &= o.plane[k];
    return *this;
  }
  /// The nodes of this set that are not in the other.
  NodeMask without(const NodeMask& o) const {
    NodeMask m = *this;
    for (int k = 0; k < kCubeSize; ++k) m.plane[k] &= ~o.plane[k];
    return m;
  }
  /// The set with the 26 neighbours of each node, within the cube.
  NodeMask grown() const {
    constexpr std::uint64_t kFirst = 0x0101010101010101u, kLast = kFirst << 7;
    NodeMask flat, m;
    for (int k = 0; k < kCubeSize; ++k) {
      const std::uint64_t x = plane[k] | (plane[k] & ~kLast) << 1 | (plane[k] & ~kFirst) >> 1;
      flat.plane[k] = x | x << 8 | x >> 8;
    }
    for (int k = 0; k < kCubeSize; ++k)
      m.plane[k] = flat.plane[k] | (k > 0 ? flat.plane[k - 1] : 0) | (k + 1 < kCubeSize ? flat.plane[k + 1] : 0);
    return m;
  }
  /// All nodes of the rows that hold a node of the set.
  NodeMask whole_rows() const {
    NodeMask m;
    for (int k = 0; k < kCubeSize; ++k) {
      std::uint64_t x = plane[k];
      x |= x >> 4 & 0x0f0f0f0f0f0f0f0fu;
      x |= x >> 2 & 0x3f3f3f3f3f3f3f3fu;
      x |= x >> 1;
      m.plane[k] = (x & 0x0101010101010101u) * 0xff;
    }
    return m;
  }
  /// Calls f(j, k, bits) for each row with a node, in memory order.
  template <class F>
  void for_rows(const F& f) const {
    for (int k = 0; k < kCubeSize; ++k)
      for (std::uint64_t left = plane[k]; left != 0;) {
        const int j = std::countr_zero(left) / 8;
        f(j, k, static_cast<std::uint8_t>(left >> (8 * j)));
        left &= ~(std::uint64_t{0xff} << (8 * j));
      }
  }
};

}  // namespace brim
