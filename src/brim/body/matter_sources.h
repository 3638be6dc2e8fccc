#pragma once

#include <cstdint>

namespace brim {

/// Optional interface of bodies whose nodes of the grid follow another rule than the material at their place: the map
/// of a contact then gives the rate of the density. Links, forces and sensors hold the material itself.
/// Tests: tests/world/matter_points_test.cpp
class MatterSources {
 public:
  virtual ~MatterSources() = default;
  /// Source to pass to make_map for the material at a point. @param source  of a node near it
  virtual std::int32_t source_of_matter(std::int32_t source) const = 0;
};

}  // namespace brim
