#pragma once

#include <set>
#include <string>

#include "brim/scene/node.h"
#include "brim/world/expectation.h"

namespace brim {

/// An entry of "expect". @param bodies  names; null when not all bodies could be read  @param end  [s] of the run
/// @throws InputError  Tests: tests/scene/bad_scenes_test.cpp
Expectation read_expectation(const Node& n, const std::set<std::string>* bodies, double end);

}  // namespace brim
