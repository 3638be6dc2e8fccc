#pragma once

#include <functional>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/body/kinematic.h"

namespace brim {

/// Motions that were given to obstacles between steps (World::set_velocity, World::set_target). Part of the world's
/// state, in its memory:
///   memory: [−0.1875, n, and for every motion ten numbers]; nothing if none was given
///   numbers: body, 0, 0, velocity (3), spin (3), 0; or body, 1, time, position (3), quaternion w x y z
/// Tests: tests/world/kinematic_motions_test.cpp
class KinematicMotions {
 public:
  /// The body of a number; null for a number that is none.
  using Bodies = std::function<Body*(int)>;

  void set(int body, const KinematicMotion& motion, const Bodies& bodies);
  /// Reads and removes its part of memory, and sets the motions as it says. Entries that mean no obstacle are ignored.
  void take(std::vector<double>& memory, const Bodies& bodies);
  /// Writes it in front of the rest of memory.
  void keep(std::vector<double>& memory) const;

 private:
  /// Gives the bodies in the list their motions, or lets them go.
  static void apply(std::span<const double> list, bool given, const Bodies& bodies);

  std::vector<double> list_;  ///< sorted by body
};

}  // namespace brim
