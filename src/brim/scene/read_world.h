#pragma once

#include <set>
#include <string>

#include "brim/scene/node.h"
#include "brim/world/levels.h"
#include "brim/world/world.h"

namespace brim {

/// "world" of a scene, except levels. @throws InputError  Tests: tests/scene/quality_test.cpp
WorldOptions read_world(const Node& n);

/// "levels" of "world". They are chosen once per frame, so that each frame's record contains them.
LevelOptions read_levels(const Node& n, int steps_per_frame);
/// @throws InputError when levels are given for a name that is not a body
void check_levels(const Node& n, const std::set<std::string>& bodies);

}  // namespace brim
