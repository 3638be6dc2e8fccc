#pragma once

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies that know their centre of mass themselves. Of others it follows from the momentum of
/// rigid motions (center_of_mass), which trees that are fixed to the world do not have.
/// Tests: tests/body/articulated_body_test.cpp
class MassCenter {
 public:
  virtual ~MassCenter() = default;
  /// [m] at the last update. The mass must be above 0.
  virtual Vec3 mass_center() const = 0;
};

}  // namespace brim
