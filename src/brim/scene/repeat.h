#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "brim/math/types.h"
#include "brim/scene/node.h"
#include "brim/scene/placement.h"

namespace brim {

inline constexpr std::size_t kMaxBodies = 1'000'000;

/// Numbers that are the same on every machine (SplitMix64, Steele, Lea and Flood 2014).
class SceneRandom {
 public:
  explicit SceneRandom(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  /// Uniform in [0, 1).
  double unit() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  /// Uniform in [-1, 1).
  double symmetric() { return 2.0 * unit() - 1.0; }

 private:
  std::uint64_t state_;
};

/// Uniformly distributed rotation (Shoemake 1992).
Quat random_rotation(SceneRandom& random);

/// Number of bodies that a body's node stands for, without making them.
std::size_t repeat_count(const Node& body);

/// The transform of a body's node, and one placement for each of its copies: the grid of "repeat", centred on the
/// position in x and y and rising from it in z, each copy moved and turned at random by its seed and number alone.
/// @throws InputError  for a rotation of length zero
std::vector<Placement> placements(const Node& body);

}  // namespace brim
