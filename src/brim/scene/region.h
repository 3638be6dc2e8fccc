#pragma once

#include <functional>

#include "brim/math/types.h"
#include "brim/scene/node.h"

namespace brim {

/// Signed distance [m], negative inside.
using RegionDistance = std::function<double(const Vec3&)>;

/// To the regions of a list together; far where there are none. Beside several it is exact, within them a bound.
RegionDistance region_distance(const Node& list);

/// Of a fluid: whole boxes, planes with a direction.
/// @throws InputError  that says what is wrong with the first one that is not so
void check_regions(const Node& list);

}  // namespace brim
