#pragma once

#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Area of a patch of contact nodes, [m²]: total of the squares of side h, in the plane perpendicular to the mean
/// normal, that contain a node, each weighted by how far it shares in the load of its patch,
///   A = Σ h² min(1, f / (0.05 f̄)) / slope,   f̄ = Σ f² / Σ f
/// f: sum of the normal forces in the square, sums over squares that touch each other. Beside a curved contact, ramps
/// overlap faintly over the gap: such squares hold hundredths of f̄ and less and hardly count. Under the pressure of
/// Hertz the weight takes less than 0.1 % of the area. Accurate to half a square along the border; for contact held by
/// rows at a few points only these count. Tests: tests/world/sense/contact_area_test.cpp, force_sensor_test.cpp
class ContactArea {
 public:
  /// @param normal_force  [N] on either side  @param h  [m] voxel at which the two parts meet
  void add(const Vec3& position, const Vec3& normal_force, double h);
  /// Returns the area of the points added and clears them.
  double take();

 private:
  struct Node {
    Vec3 position;
    double h, force;
  };
  std::vector<Node> nodes_;
  Vec3 normal_ = Vec3::Zero();
};

}  // namespace brim
