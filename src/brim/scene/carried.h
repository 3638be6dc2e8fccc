#pragma once

#include "brim/body/volume/carried_body.h"
#include "brim/scene/constraints.h"
#include "brim/scene/repeat.h"

namespace brim {

/// The elastic keys that deformable volumes and meshless bodies share; constraints and the voxel size are left out.
ElasticOptions read_elastic(const Node& body, const Placement& place, const Material& material);

}  // namespace brim
