#pragma once

#include <memory>
#include <span>

#include "brim/grid/tile.h"
#include "brim/math/types.h"

namespace brim {

/// Pose of a rigid shape: world = rotation * local + translation.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
  Vec3 to_local(const Vec3& world) const { return rotation.transpose() * (world - translation); }
};

/// A rigid solid given by its signed distance. Its density is ramp(distance, w) (paper, sections 5.2 and 5.3).
class Shape {
 public:
  virtual ~Shape() = default;

  /// Signed distance to the surface, negative inside, [m]; local frame. Never larger in magnitude than the true one.
  virtual double distance(const Vec3& p) const = 0;
  /// Bounding box of the solid, local frame, [m]; infinite for half-spaces.
  virtual Aabb bounds() const = 0;
  /// The same for the placed solid, in world axes.
  virtual Aabb placed_bounds(const Pose& pose) const;
  /// Smallest thickness of the solid, [m], for warnings.
  virtual double thickness() const = 0;
  /// True for the half-space z <= 0, which motion along its surface leaves as it is.
  virtual bool half_space() const { return false; }

  /// Writes the density at every node of a block; source is left at 0.
  virtual void fill(const Pose& pose, const TileKey& tile, double h, double w, DensityBlock& out) const = 0;
};

/// Ball of the given radius about the origin.
std::shared_ptr<const Shape> make_sphere(double radius);
/// Box of the given full extents about the origin.
std::shared_ptr<const Shape> make_box(const Vec3& extents);
/// Points within `radius` of the segment (0, 0, ±length/2).
std::shared_ptr<const Shape> make_capsule(double radius, double length);
/// Cylinder about z of the given radius and full height.
std::shared_ptr<const Shape> make_cylinder(double radius, double height);
/// Ring around z: points within `tube` of the circle of the given radius, tube < radius.
std::shared_ptr<const Shape> make_torus(double radius, double tube);
/// Half-sphere shell, open towards +z, with a round rim; the outer sphere's centre is the origin.
std::shared_ptr<const Shape> make_bowl(double radius, double thickness);
/// Cylindrical beaker with a floor, open towards +z, standing on z = 0; outer radius and full height.
std::shared_ptr<const Shape> make_cup(double radius, double height, double thickness);
/// Half-space z <= 0.
std::shared_ptr<const Shape> make_half_space();

/// Tiles within the region whose block may hold density of the placed shape.
void shape_presence(const Shape& shape, const Pose& pose, double h, double w, const Aabb& region,
                    std::vector<TileKey>& out);

/// Writes the wanted octants of one block, or all of it, from any callable double distance(const Vec3& local). Cubes
/// wholly inside or outside are recognised from the distance at their centre, and runs of nodes far from the surface
/// from their first.
/// @param distance  Lipschitz constant 1, up to an error of at most slack [m]
template <class Distance>
void fill_block(const Distance& distance, const Pose& pose, const TileKey& tile, double h, double w, DensityBlock& out,
                double slack = 0.0);

}  // namespace brim

#include "brim/raster/shape_fill.h"
