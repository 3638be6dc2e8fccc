#pragma once

#include "brim/grid/node_cube.h"
#include "brim/raster/shape.h"

namespace brim {

/// The rows of a cube in the frame of a shape: node (i, j, k) sits at base + i dx + j dy + k dz, [m].
struct CubeFrame {
  Vec3 base, dx, dy, dz;
  CubeFrame(const Pose& pose, const NodeCube& cube)
      : base(pose.to_local(cube.origin())),
        dx(cube.h * pose.rotation.row(0)),
        dy(cube.h * pose.rotation.row(1)),
        dz(cube.h * pose.rotation.row(2)) {}
};

/// Signed distances, [m], of solids about the origin at all nodes of the rows that contain a wanted one, eight nodes at
/// a time in single precision; sizes as for make_sphere and the others, but half extents, lengths and heights. Same
/// bits for any instruction set.
void sphere_distances(const CubeFrame& frame, double radius, const NodeMask& wanted, float* d);
void box_distances(const CubeFrame& frame, const Vec3& half, const NodeMask& wanted, float* d);
void capsule_distances(const CubeFrame& frame, double radius, double half, const NodeMask& wanted, float* d);
void cylinder_distances(const CubeFrame& frame, double radius, double half, const NodeMask& wanted, float* d);
void torus_distances(const CubeFrame& frame, double radius, double tube, const NodeMask& wanted, float* d);
void bowl_distances(const CubeFrame& frame, double middle, double half, const NodeMask& wanted, float* d);
void cup_distances(const CubeFrame& frame, double radius, double height, double thickness, const NodeMask& wanted,
                   float* d);
void half_space_distances(const CubeFrame& frame, const NodeMask& wanted, float* d);

/// rho = ramp(d, w) on all nodes of the rows that contain a wanted one.
void cube_ramp(const float* d, double w, const NodeMask& wanted, float* rho);

}  // namespace brim
