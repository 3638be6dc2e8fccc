#pragma once

#include "brim/body/body.h"
#include "brim/body/distance_bound.h"
#include "brim/core/interface_of.h"

namespace brim {

/// The part as a solid with its pose; null when it is none. @param part  in [0, part_count)
inline const PosedShape* solid_of(const Body& body, int part) {
  const auto* bound = interface_of<DistanceBound>(body);
  return bound != nullptr ? bound->solid(part) : nullptr;
}

}  // namespace brim
