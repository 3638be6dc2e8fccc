#pragma once

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
  virtual void note_contacts(std::span<const Vec3> points) = 0;
};

}  // namespace brim
