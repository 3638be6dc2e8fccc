#pragma once

#include <optional>
#include <vector>

#include "brim/record/export/format.h"

/// What formats of one animated file need: all frames of a body, and whether it moved as a rigid one.
namespace brim::exporting {

/// Frames of all items, kept until the file is written.
struct Film {
  std::vector<double> times;                                  ///< [s], shape (frames)
  std::vector<std::int64_t> indices;                          ///< frames in the run
  std::vector<std::vector<std::vector<Vec3f>>> positions;     ///< [item][frame]; one frame of an item that is still
  std::vector<std::vector<std::vector<Triangle>>> triangles;  ///< likewise, of items whose triangles change; else empty
  std::vector<std::vector<std::vector<Vec3f>>> velocities;    ///< likewise; empty lists where the run has none
  std::vector<std::vector<ContactSample>> contacts;           ///< [frame]

  void add(const Job& job, const Frame& frame);
};

/// Placement of a body in a frame: world = rotation * local + translation.
struct Placement {
  Quat rotation = Quat::Identity();
  Vec3 translation = Vec3::Zero();
};

/// A body's movement as that of one rigid shape.
struct RigidMotion {
  std::vector<Vec3f> local;           ///< [m] vertices about their mean in the first frame
  std::vector<Placement> placements;  ///< per frame; neighbouring quaternions on one hemisphere
};

/// The rigid movement that explains all frames, by least squares (Kabsch 1976; Umeyama 1991), or nothing when a vertex
/// strays from it by more than rounding: 4e-6 of the scene's reach.
std::optional<RigidMotion> find_rigid_motion(const std::vector<std::vector<Vec3f>>& frames);

}  // namespace brim::exporting
