#pragma once

#include <optional>
#include <string>

#include "brim/body/body.h"

namespace brim {

/// Centre of mass of the last updated state, [m], for every kind that can move as a rigid whole; nothing for others:
/// of the rotation u = w × x about the origin the momentum is m w × c.
std::optional<Vec3> center_of_mass(const Body& body);

/// That, or the mean of the display's vertices: where a body is.
Vec3 middle_of(const Body& body);

/// Why a body cannot be set elsewhere and turned by R, in words that follow its name; empty: it can.
std::string refuses_move(const Body& body, const Mat3& R);
/// True when moving it is to move its base (MovableBase), and not its coordinates.
bool moves_by_base(const Body& body);

}  // namespace brim
