#pragma once

#include <set>
#include <string>

#include "brim/scene/node.h"
#include "brim/world/sense/sensor_model.h"

namespace brim {

class World;

/// What a scene says under "sensors" (docs/sensors.md). Names of bodies, and what of them can be read, are checked
/// where sensors are added.  Tests: tests/scene/sensors_test.cpp
/// @throws InputError

/// An entry of "sensors". @param groups  "groups" of the scene, or nothing
SensorModel read_sensor(const Node& sensor, const Json* groups);
/// Checks an entry: all that can be known without bodies. @param names  of those before it; its own is added
void check_sensor(const Node& sensor, const Json* groups, std::set<std::string>& names);
/// Adds the sensors of a scene, and checks that its expectations ask for readings that they have.
void add_sensors(const Node& root, World& world);

}  // namespace brim
