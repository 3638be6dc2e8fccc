#pragma once

#include <optional>
#include <string>

#include "brim/body/body.h"

namespace brim {

/// Centre of mass c of the last updated state, [m], for every kind that knows it (MassCenter) or can move as a rigid
/// whole; nothing for others. Found from the momentum m w × c of the rotation u = w × x about the origin.
std::optional<Vec3> center_of_mass(const Body& body);

/// Centre of mass, or else the mean of the display's vertices.
Vec3 middle_of(const Body& body);

/// Reason why a body cannot be moved and rotated by R, as words that follow its name; empty: it can.
std::string refuses_move(const Body& body, const Mat3& R);
/// True when a move changes the body's base (MovableBase), not its coordinates.
bool moves_by_base(const Body& body);

}  // namespace brim
