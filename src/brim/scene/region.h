#pragma once

#include <functional>

#include "brim/math/types.h"
#include "brim/scene/node.h"

namespace brim {

/// Signed distance [m], negative inside.
using RegionDistance = std::function<double(const Vec3&)>;

/// Distance to the union of a list's regions; large when the list is empty. Exact outside, a bound inside several.
RegionDistance region_distance(const Node& list);

/// Checks regions of a fluid: boxes of positive size, planes with a direction.
/// @throws InputError  about the first invalid one
void check_regions(const Node& list);

}  // namespace brim
