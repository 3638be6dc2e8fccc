#pragma once

#include <span>
#include <string>

#include "brim/world/world.h"

/// Checks of what a user gives a world. All throw InputError with the place, the value and what is allowed.
/// Tests: tests/world/given_values_test.cpp
namespace brim {

/// @param of  place, which begins the message
void need_number(const std::string& of, const char* what, double value, double least, double most);
/// Friction, restitution and rolling resistance.
void need_material(const std::string& of, const Material& material);
/// The same of a pair, of which negative numbers mean that it has none of its own.
void need_pair_material(const std::string& of, const PairMaterial& pair);
/// Grid step, thickness and material of all parts of a body.
void need_parts(const Body& body);
/// Coordinates and velocities: finite, and of what turns with a quaternion near length 1.
void need_coordinates(const char* of, const Body& body, std::span<const double> q, std::span<const double> v);
void need_options(const WorldOptions& options);

}  // namespace brim
