#pragma once

#include <span>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of maps that take a force whole along one direction alone at each point, as the surface of a
/// fluid that slips does: contact acts along it, so that the other side loses what this one gets.
class DirectedMap {
 public:
  virtual ~DirectedMap() = default;
  /// Unit vectors out of the body, shape (points); zero where a force is taken whole whatever its direction.
  virtual std::span<const Vec3> directions() const = 0;
};

}  // namespace brim
