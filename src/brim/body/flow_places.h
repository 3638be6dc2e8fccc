#pragma once

#include <span>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies whose matter flows through fixed places, as a fluid on a grid does: velocity i is along
/// axis i modulo 3 at a place of its own. A region then means the fluid inside it at the time.
/// Tests: tests/world/wind_test.cpp
class FlowPlaces {
 public:
  virtual ~FlowPlaces() = default;
  /// [m] place of each velocity; shape (v_size()).
  virtual void velocity_places(std::span<Vec3> x) const = 0;
};

}  // namespace brim
