#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "brim/math/types.h"
#include "brim/raster/shape.h"

namespace brim {

class Body;

/// Initial positions (at construction) of a body's material, found from present ones: exact on solids, elsewhere that
/// of the nearest display vertex, accurate to the mesh size. Used to evaluate regions of sensors and filters. Tests:
/// tests/world/sense/force_sensor_test.cpp, tests/world/part_filter_test.cpp
class StartPlaces {
 public:
  /// @param body  as it is now  @throws InputError for kinds that carry nothing along, such as fluids
  explicit StartPlaces(const Body& body);
  /// Initial position of the material now at x, [m]. @param part  of the body
  Vec3 of(int part, const Vec3& x);
  /// To be called when the body has moved.
  void moved() { known_ = false; }
  /// Sorts the vertices at their present positions: until the body moves, `of` may then be called from many threads.
  void follow() {
    if (pose_.empty() && !known_) sort_vertices();
  }

 private:
  void sort_vertices();

  const Body& body_;
  std::vector<Pose> pose_;    ///< for solids, shape (parts)
  std::vector<Vec3f> start_;  ///< for other bodies: of the vertices
  std::vector<Vec3f> now_;
  double cell_ = 0.0;                                                      ///< [m]
  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> vertices_;  ///< by cell
  bool known_ = false;
};

}  // namespace brim
