#pragma once

#include <cstdint>

#include "brim/math/types.h"

namespace brim {

/// Optional interface of bodies whose nodes move past each other, as the particles of a fluid do. A place between them
/// does not stay attached to any node, so links and forces hold the nodes themselves.
/// Tests: tests/world/loose_links_test.cpp
class LooseNodes {
 public:
  virtual ~LooseNodes() = default;
  /// The node nearest to x in the last updated state; the first of several.
  virtual std::int32_t nearest_node(const Vec3& x) const = 0;
  /// Source to pass to make_map for the node itself: its row is the node's velocity, wherever the point is.
  virtual std::int32_t source_of_node(std::int32_t node) const = 0;
};

}  // namespace brim
