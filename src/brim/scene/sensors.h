#pragma once

#include <set>
#include <string>

#include "brim/scene/node.h"
#include "brim/world/sense/sensor_model.h"

namespace brim {

class World;

/// "sensors" of a scene (docs/sensors.md). Names of bodies, and the quantities they provide, are checked when sensors
/// are added.  Tests: tests/scene/sensors_test.cpp
/// @throws InputError

/// An entry of "sensors". @param groups  "groups" of the scene, or null
SensorModel read_sensor(const Node& sensor, const Json* groups);
/// Checks an entry as far as possible without bodies. @param names  of earlier entries; its own is added
void check_sensor(const Node& sensor, const Json* groups, std::set<std::string>& names);
/// Adds the sensors of a scene, and checks that they have the readings that its expectations use.
void add_sensors(const Node& root, World& world);

}  // namespace brim
