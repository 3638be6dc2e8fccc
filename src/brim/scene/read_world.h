#pragma once

#include <set>
#include <string>

#include "brim/scene/node.h"
#include "brim/world/levels.h"
#include "brim/world/world.h"

namespace brim {

/// "world" of a scene, its levels aside. @throws InputError  Tests: tests/scene/quality_test.cpp
WorldOptions read_world(const Node& n);

/// "levels" of "world". They are chosen once a frame, so that a frame's record has them.
LevelOptions read_levels(const Node& n, int steps_per_frame);
/// @throws InputError when levels are given for what is no body
void check_levels(const Node& n, const std::set<std::string>& bodies);

}  // namespace brim
