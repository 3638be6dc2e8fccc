#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/contact/cube_contacts.h"
#include "brim/math/types.h"

namespace brim {

/// Distances to a flat surface about a point x: d(y) = gap + slope·(y − x).
struct SurfacePlane {
  double gap = 0.0;           ///< [m]
  Vec3 slope = Vec3::Zero();  ///< unit, away from the part
};

/// Fits a plane to the nodes' distances to one surface. Distances are exact where stencil gradients are not, so normals
/// of flat faces become exact. Nodes at an edge that look level are left out, if they are few.
/// @param h      [m] grid step
/// @param level  workspace
/// @return false when the surface is not a plane, or too few nodes can be used
/// Tests: tests/response/patch_planes_test.cpp
bool fit_plane(const ContactSet& contacts, std::span<const std::size_t> nodes, bool of_a, const Vec3& x, double h,
               std::vector<std::size_t>& level, SurfacePlane& plane);

/// The same from distances to the solid itself, at nine places within half a voxel of x: on a face so small that all
/// its nodes see its edges.
/// @param n  unit, roughly the normal of the face, away from the part
bool probe_plane(const CubeSide& side, const Vec3& x, const Vec3& n, double h, SurfacePlane& plane);

}  // namespace brim
