#pragma once

#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/raster/known_distance.h"
#include "brim/raster/shape.h"

namespace brim {

/// A solid with its pose in the world: common part of rigid bodies, obstacles and links of trees.
class PosedShape {
 public:
  /// @param surface  of the solid, for display, shape's frame; may be empty
  PosedShape(std::shared_ptr<const Shape> shape, Shared<TriMesh> surface);

  const Shape& shape() const { return *shape_; }
  const TriMesh& surface() const { return *surface_; }
  /// Its triangles, shared by all bodies with this surface.
  SharedList<Triangle> triangles() const { return surface_.list(&TriMesh::triangles); }
  const Pose& pose() const { return pose_; }
  /// The shape's distance function; null when its density is not a ramp of a distance.
  const KnownDistance* known_distance() const { return known_; }
  /// Shapes to average over the ramp: those with detail, for coarse voxels, or all.
  enum class Averaged { Detailed, All };
  /// The same, averaged over balls as wide as the ramp. @param w  [m] ramp width
  const KnownDistance* known_distance_averaged(double w, Averaged which) const;
  void place(const Pose& pose) { pose_ = pose; }

  /// Distance from a point to the farthest corner of the solid's box, [m]; 0 when the box is infinite.
  /// @param center  [m] shape's frame
  double box_reach(const Vec3& center) const;
  /// The same to the farthest vertex of the surface, which is tighter; to the box if there is no surface.
  double reach(const Vec3& center) const;

  Aabb bounds() const { return shape_->placed_bounds(pose_); }
  void presence(double h, double w, const Aabb& region, std::vector<TileKey>& out) const;
  /// DistanceBound::distance_bound.
  double distance_bound(const Vec3& x) const;
  void rasterize(double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const;
  /// Positions of the surface's vertices, [m], shape (vertices of the surface).
  void display_positions(std::span<Vec3f> x) const;

 private:
  std::shared_ptr<const Shape> shape_;
  const KnownDistance* known_;
  Shared<TriMesh> surface_;
  Pose pose_;
};

}  // namespace brim
