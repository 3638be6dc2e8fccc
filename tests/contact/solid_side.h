#pragma once

#include <memory>

#include "brim/contact/cube_contacts.h"
#include "brim/raster/shape.h"

namespace brim::testing {

/// A shape at a pose as one side of a search for contacts.
inline CubeSide solid_side(const std::shared_ptr<const Shape>& shape, const Pose& pose) {
  CubeSide s;
  s.solid = dynamic_cast<const KnownDistance*>(shape.get());
  s.pose = pose;
  return s;
}

}  // namespace brim::testing
