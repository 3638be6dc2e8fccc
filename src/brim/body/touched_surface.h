#pragma once

#include <cstdint>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies whose surface moves differently where touched: a grid fluid's moves there with the
/// velocity used by contact, and follows its material elsewhere.
class TouchedSurface {
 public:
  virtual ~TouchedSurface() = default;
  /// Called once per sub-step, after contacts have been found and before the body advances.
  /// @param points  [m] nodes of its contacts, inactive ones included; empty: nothing is near
  /// @param by_fluid  nonzero when the other side is a fluid: then neither side has a single direction of force, and
  ///                  each must accept any; shape (points)
  virtual void note_contacts(std::span<const Vec3> points, std::span<const std::uint8_t> by_fluid) = 0;
};

}  // namespace brim
