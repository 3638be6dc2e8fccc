#pragma once

#include <span>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies whose matter moves through places that stay, as a fluid on a grid does: velocity i is
/// along axis i modulo 3 at a place of its own. A region is then one of space, and what is in it at the time is meant.
/// Tests: tests/world/wind_test.cpp
class FlowPlaces {
 public:
  virtual ~FlowPlaces() = default;
  /// Of each velocity, [m]; shape (v_size()).
  virtual void velocity_places(std::span<Vec3> x) const = 0;
};

}  // namespace brim
