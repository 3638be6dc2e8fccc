#pragma once

#include <set>
#include <string>

#include "brim/scene/node.h"

namespace brim {

/// @throws InputError when `name` (a value at n, or its key) is not a body, suggesting the nearest name
void need_body(const Node& n, const std::string& name, const std::set<std::string>& bodies);

}  // namespace brim
