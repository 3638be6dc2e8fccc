#pragma once

#include "brim/grid/node_cube.h"
#include "brim/raster/convex_distance.h"
#include "brim/raster/cube_distances.h"
#include "brim/raster/place_distances.h"
#include "brim/raster/shape.h"

namespace brim {

/// Optional interface of shapes whose density is ramp(distance, w), with a distance of Lipschitz constant 1 up to
/// errors of at most slack. Their nodes can be sampled one cube at a time.
/// Tests: tests/raster/cube_distances_test.cpp
class KnownDistance {
 public:
  virtual ~KnownDistance() = default;
  virtual double slack() const = 0;  ///< [m]
  /// The distance, or a cheaper value that differs from it by less than slack, [m]. @param p  [m] shape's frame
  virtual double rough_distance(const Vec3& p) const = 0;
  /// The distance at many points, [m], as accurately as known.
  virtual void distances(const PlaceArrays& at, double* d) const {
    for (int i = 0; i < at.count; ++i) d[i] = rough_distance({at.x[i], at.y[i], at.z[i]});
  }
  /// A lower bound of the distance, [m], for the exact and for the approximate one.
  virtual double least_distance(const Vec3& p) const { return rough_distance(p) - slack(); }
  /// A lower bound at eight points of a cube, (i, j, k) in nodes from its first one; single precision, error about 1e-7
  /// of the shape's size.
  virtual void least_distances(const CubeFrame& frame, const float* i, const float* j, const float* k,
                               float* out) const {
    for (int l = 0; l < kCubeSize; ++l)
      out[l] = static_cast<float>(
          least_distance(frame.base + double{i[l]} * frame.dx + double{j[l]} * frame.dy + double{k[l]} * frame.dz));
  }
  /// Distances at the wanted nodes of a cube, [m], in single precision: error about 1e-7 of the shape's size. Values
  /// farther than reach need only be beyond reach on the right side. Other nodes of the rows with wanted ones are
  /// overwritten. The default calls rough_distance node by node.
  /// @param reach  [m]
  virtual void cube_distances(const Pose& pose, const NodeCube& cube, const NodeMask& wanted, double reach,
                              float* d) const {
    (void)reach;
    const CubeFrame f(pose, cube);
    wanted.for_rows([&](int j, int k, std::uint8_t row) {
      for (int i = 0; i < kCubeSize; ++i)
        if ((row >> i & 1) != 0)
          d[cube_index(i, j, k)] = static_cast<float>(rough_distance(f.base + i * f.dx + j * f.dy + k * f.dz));
    });
  }
  /// True for distances given by a formula: a whole row then costs no more than one node, and values are exact beyond
  /// reach too.
  virtual bool by_rows() const = 0;
  /// True when distances tell the direction of the surface better than densities do: values up to a step beyond reach
  /// are then as good as those within.
  virtual bool tells_direction() const { return by_rows(); }
  /// The same shape, if it is convex and its distance has a gradient; else null.
  virtual const ConvexDistance* convex() const { return nullptr; }
};

}  // namespace brim
