#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "brim/math/types.h"
#include "brim/raster/shape.h"

namespace brim {

class Body;

/// Places of a body's matter when this was made, found again wherever it is now: exactly on solids, elsewhere that of
/// the nearest vertex the body shows, which is as fine as its mesh. What regions of sensors and filters are asked
/// about. Tests: tests/world/sense/force_sensor_test.cpp, tests/world/part_filter_test.cpp
class StartPlaces {
 public:
  /// @param body  as it is now  @throws InputError where it carries nothing along, as fluids do
  explicit StartPlaces(const Body& body);
  /// Where the matter at x was, [m]. @param part  of the body
  Vec3 of(int part, const Vec3& x);
  /// Forgets where vertices are: the body has moved.
  void moved() { known_ = false; }
  /// Finds where they are: until the body moves, `of` may then be called from many threads.
  void follow() {
    if (pose_.empty() && !known_) sort_vertices();
  }

 private:
  void sort_vertices();

  const Body& body_;
  std::vector<Pose> pose_;    ///< of solids, shape (parts)
  std::vector<Vec3f> start_;  ///< of the vertices of others
  std::vector<Vec3f> now_;
  double cell_ = 0.0;                                                      ///< [m]
  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> vertices_;  ///< by cell
  bool known_ = false;
};

}  // namespace brim
