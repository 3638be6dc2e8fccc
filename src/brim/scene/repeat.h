#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "brim/math/types.h"
#include "brim/scene/node.h"
#include "brim/scene/placement.h"

namespace brim {

inline constexpr std::size_t kMaxBodies = 1'000'000;

/// Random numbers that are the same on every machine (SplitMix64, Steele, Lea and Flood 2014).
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

/// Number of bodies in a body's node, without making them.
/// @throws InputError  when a "repeat" has neither "count" nor "around"
std::size_t repeat_count(const Node& body);

/// The transform of a body's node, and one placement per copy: the grid of "repeat", centred on the position in x and y
/// and rising from it in z, each copy displaced and rotated at random by its seed and number alone; and that grid
/// turned about the axis of "around" (circle.h) for each place of the circle, first to last.
/// Tests: tests/scene/circle_test.cpp
/// @throws InputError  for velocities beyond what can be stepped, and as repeat_count and read_circle
std::vector<Placement> placements(const Node& body);

}  // namespace brim
