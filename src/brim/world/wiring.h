#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "brim/world/links.h"
#include "brim/world/outer_actions.h"

namespace brim {

/// Attachments and forces that exist in a state of a world (State::wiring), which restoring it brings back. Made anew
/// whenever one is added; states share it. Tests: tests/world/wiring_test.cpp
struct Wiring {
  /// Number of the world to which links and forces belong; of another world, or without one (0), only names count.
  std::uint64_t world = 0;
  Links::List links;
  OuterActions::List forces;
  std::vector<std::string> link_names, force_names;  ///< in their order
};

}  // namespace brim
