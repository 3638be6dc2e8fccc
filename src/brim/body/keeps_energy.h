#pragma once

#include <span>

namespace brim {

/// Optional interface of bodies that limit the energy of their free motion: forces that act explicitly, as those of a
/// rotating frame do, bring energy into loose bodies at long steps, and nothing else takes it out.
/// Tests: tests/world/free_flight_test.cpp
class KeepsEnergy {
 public:
  virtual ~KeepsEnergy() = default;
  /// At the end of a sub-step in which nothing but uniform gravity acted on the body: slows its inner motion where its
  /// energy about the centre of mass exceeds that of the last update. Both momenta stay. The body is updated to q and
  /// v.
  /// @param time  at the end of the sub-step
  virtual void keep_energy(double time, std::span<const double> q, std::span<double> v) = 0;
};

}  // namespace brim
