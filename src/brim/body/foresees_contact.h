#pragma once

#include <span>

namespace brim {

/// Optional interface of bodies whose inner forces hold contacts of their own, such as grains on grains and limits of
/// joints. Grains that the velocities at the start of a step do not close may close in it: where one is stopped, the
/// next, which came along at the same speed, would be inside it at the end, and the energy of that overlap came from
/// nowhere. A limit on which a joint rests at the start would hold back what a blow takes away from it.
/// Tests: tests/body/points_body_test.cpp, tests/world/grain_blow_test.cpp
class ForeseesContact {
 public:
  virtual ~ForeseesContact() = default;
  /// Between two solves of a step, after begin_solve: adds the contacts that the last solve closes, or takes away those
  /// that it opens.
  /// @param v  velocities at the end of the step, shape (v_size)
  /// @return true when forces and matrices have changed
  virtual bool foresee(std::span<const double> v) = 0;
};

}  // namespace brim
