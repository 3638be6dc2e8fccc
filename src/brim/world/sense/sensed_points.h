#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "brim/world/matter_points.h"

namespace brim {

class World;

/// Material points of one body that a sensor follows, with their velocities.
/// Tests: tests/world/sense/motion_sensor_test.cpp
class SensedPoints {
 public:
  /// @param body  its number  @param part  of the body; −1: the one nearest to the first point  @param x  [m] now
  /// @throws InputError  for bodies that have no points to follow
  SensedPoints(const World& world, int body, int part, std::vector<Vec3> x);
  void find_body(const World& world);
  /// False while the body is out of the world.
  bool present(const World& world) const;
  int body() const { return body_; }

  /// Positions in the world's present state, [m].
  std::span<const Vec3> positions(const World& world);
  /// Velocities, [m/s]; after positions.
  std::span<const Vec3> velocities(const World& world);

 private:
  WorldPart part_;
  int body_ = -1;
  MatterPoints points_;
  std::unique_ptr<Map> map_;
  std::vector<Vec3> velocity_;
};

/// The number of the one body of that name. @throws InputError
int only_body(const World& world, const std::vector<std::string>& words);

}  // namespace brim
