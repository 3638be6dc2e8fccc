#pragma once

#include "brim/scene/node.h"
#include "brim/world/applied_force.h"

namespace brim {

/// The "field" of a wind: formulas in x, y, z, t and constants, in axes that its transform may move.
/// @throws InputError with the place of the error  Tests: tests/scene/wind_field_test.cpp
WindField read_wind_field(const Node& field);

}  // namespace brim
