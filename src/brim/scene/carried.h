#pragma once

#include "brim/body/volume/carried_body.h"
#include "brim/scene/constraints.h"
#include "brim/scene/repeat.h"

namespace brim {

/// The elastic keys shared by deformable volumes and meshless bodies; without constraints, and with the
/// voxel size as given.
ElasticOptions read_elastic(const Node& body, const Placement& place, const Material& material);

}  // namespace brim
