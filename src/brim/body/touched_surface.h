#pragma once

#include <cstdint>
#include <span>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies whose surface moves otherwise where others touch it: a grid fluid's keeps to what
/// contact was told there, and follows its matter everywhere else.
class TouchedSurface {
 public:
  virtual ~TouchedSurface() = default;
  /// Told once a sub-step, after contacts have been found and before the body is advanced.
  /// @param points  [m] nodes of its contacts, waiting ones among them; empty: nothing is near
  /// @param by_fluid  nonzero where it is a fluid that touches: both have no direction along which alone they give way,
  ///                  and each must take all of a force; shape (points)
  virtual void note_contacts(std::span<const Vec3> points, std::span<const std::uint8_t> by_fluid) = 0;
};

}  // namespace brim
