#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "brim/contact/contact_set.h"
#include "brim/world/world_part.h"

namespace brim {

/// Moves contact points of spinning balls (SpinningBalls) to where they touch: r ← x − R n, n from the other part. The
/// grid's contact points miss that place by some tenths of a voxel: sideways, where pressure would turn the ball, and
/// in height, where friction would keep it from rolling. After the move pressure has no torque, and the forces on both
/// parts still act at one point, so momentum is exact. Between two balls the point divides the line of centres in the
/// ratio of their radii. Links are not moved.
/// @param normals  unit, one per contact
void place_under_balls(std::span<const WorldPart> parts, std::span<const Vec3> normals, ContactSet& contacts);

/// Adds the normal loads, [N], of immobile parts on each ball of a body.
/// @param body  number in the world  @param load_at  [N] of contact c  @param load  shape (balls)
void add_fixed_loads(std::span<const WorldPart> parts, const ContactSet& contacts, std::int32_t body,
                     const std::function<double(std::size_t)>& load_at, std::span<double> load);

}  // namespace brim
