#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "brim/contact/contact_set.h"
#include "brim/world/world_part.h"

namespace brim {

/// Moves contact points of balls that turn (SpinningBalls) to where they touch: r ← x − R n, n from the other part.
/// Nodes carry a ball beside that place by some tenths of a voxel, where pressure would turn it, and at several
/// heights, where friction would keep it from rolling. There pressure has no torque, and forces of both parts still act
/// at one point, so that momentum is exact. Between two balls it is the point that divides the line of centres as their
/// radii do. Links stay.
/// @param normals  unit, one per contact
void place_under_balls(std::span<const WorldPart> parts, std::span<const Vec3> normals, ContactSet& contacts);

/// Adds to the load of each ball of a body, [N], what parts that do not move press it with.
/// @param body  number in the world  @param load_at  [N] of contact c  @param load  shape (balls)
void add_fixed_loads(std::span<const WorldPart> parts, const ContactSet& contacts, std::int32_t body,
                     const std::function<double(std::size_t)>& load_at, std::span<double> load);

}  // namespace brim
