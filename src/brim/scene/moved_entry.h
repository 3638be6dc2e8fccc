#pragma once

#include "brim/scene/node.h"

namespace brim {

/// Moves an entry of "bodies" as a whole: its transform, velocities, prescribed motions and regions of constraints.
/// @param body       changed in place; defaults need not be filled in
/// @param transform  {"position", "rotation"}, validated
/// @param written    where the body is written, for messages
/// @throws InputError  when a rotation meets what lies along the axes of the world: repeats, upright boxes, grid fluids
void move_entry(Json& body, const Node& transform, const Node& written);

/// Likewise an entry of "filters", "attachments", "joints", "forces" or "sensors": its points, regions, directions,
/// grids and prescribed motions.
void move_link(Json& link, const Node& transform, const Node& written);

/// Likewise an entry of "timeline": its offset, rotation and velocities.
void move_edit(Json& edit, const Node& transform, const Node& written);

}  // namespace brim
