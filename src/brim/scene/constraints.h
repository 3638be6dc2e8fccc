#pragma once

#include <functional>
#include <span>

#include "brim/body/meshless/held_matter.h"
#include "brim/body/particles/particle_body.h"
#include "brim/scene/node.h"

namespace brim {

/// Checks of a list of constraints that the schema cannot express; reads no files.
/// @param has_corners  whether the body is a cloth grid
/// @throws InputError
void check_constraints(const Node& list, bool has_corners);

/// True for the points of a region ("box", "sphere", "plane" or "all"). @throws InputError for corners
std::function<bool(const Vec3&)> read_region(const Node& region);

/// Adds the fixed and moved nodes of a scene to a body's options. A node selected by two entries belongs to the first.
/// @param rest     [m] initial positions of the nodes, world frame
/// @param corners  node numbers of a cloth grid's corners, or empty
/// @param turned   of the body's placement: motions turn with copies in a circle, regions are places in the world
/// @return  each entry's nodes and its region
/// @throws InputError  for an entry that selects no node
std::vector<HeldRegion> read_constraints(const Node& list, std::span<const Vec3> rest,
                                         std::span<const std::int32_t> corners, const Quat& turned,
                                         ParticleOptions& options);

}  // namespace brim
