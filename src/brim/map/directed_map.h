#pragma once

#include <span>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of maps that accept force along only one direction at each point, as the surface of a slipping
/// fluid does: contact acts along it, so that both sides get equal and opposite forces.
class DirectedMap {
 public:
  virtual ~DirectedMap() = default;
  /// Unit vectors out of the body, shape (points); zero where forces of any direction are accepted.
  virtual std::span<const Vec3> directions() const = 0;
};

}  // namespace brim
