#pragma once

#include "brim/scene/node.h"

namespace brim {

/// Transforms an entry of "bodies": its transform, velocities, prescribed motions and regions of constraints.
/// @param body       changed in place; defaults may be missing
/// @param transform  {"position", "rotation"}, validated
/// @param written    source of the body, for messages
/// @throws InputError  when a rotation meets axis-aligned data: grids of copies, upright boxes, grid fluids
void move_entry(Json& body, const Node& transform, const Node& written);

/// The same for an entry of "filters", "attachments", "joints", "forces" or "sensors": its points, regions, directions,
/// grids and prescribed motions.
void move_link(Json& link, const Node& transform, const Node& written);

/// The same for an entry of "timeline": its offset, rotation and velocities.
void move_edit(Json& edit, const Node& transform, const Node& written);

}  // namespace brim
