#pragma once

#include <optional>
#include <vector>

#include "brim/record/export/format.h"

/// For formats with one animated file: all frames of a body, and whether its motion is rigid.
namespace brim::exporting {

/// Frames of all items, kept in memory until the file is written.
struct Film {
  std::vector<double> times;                                  ///< [s], shape (frames)
  std::vector<std::int64_t> indices;                          ///< frames in the run
  std::vector<std::vector<char>> present;                     ///< [item][frame]: 0 where the item was removed
  std::vector<std::vector<std::size_t>> samples;              ///< [item]: frames of its samples; one for still items
  std::vector<std::vector<std::vector<Vec3f>>> positions;     ///< [item][sample]
  std::vector<std::vector<std::vector<Triangle>>> triangles;  ///< likewise for changing surfaces; else empty
  std::vector<std::vector<std::vector<Vec3f>>> velocities;    ///< likewise; empty lists if the run has none
  std::vector<std::vector<ContactSample>> contacts;           ///< [frame]

  void add(const Job& job, const Frame& frame);
  bool always(std::size_t item) const;
  /// Frames in which an item comes or goes, and the first one.
  std::vector<std::size_t> changes(std::size_t item) const;
};

/// Placement of a body in a frame: world = rotation * local + translation.
struct Placement {
  Quat rotation = Quat::Identity();
  Vec3 translation = Vec3::Zero();
};

/// A body's motion as that of a rigid shape.
struct RigidMotion {
  std::vector<Vec3f> local;           ///< [m] vertices relative to their mean in the first frame
  std::vector<Placement> placements;  ///< per frame; neighbouring quaternions on one hemisphere
};

/// The rigid motion that fits all frames by least squares (Kabsch 1976; Umeyama 1991), or nothing when a vertex
/// deviates by more than rounding: 4e-6 of the scene's extent.
std::optional<RigidMotion> find_rigid_motion(const std::vector<std::vector<Vec3f>>& frames);

/// Positions of a piece alone, over frames.
std::vector<std::vector<Vec3f>> cut(const std::vector<std::vector<Vec3f>>& frames, const RecordedPiece& piece);
/// Triangles of a piece alone, its vertices from 0.
std::vector<Triangle> cut(const std::vector<Triangle>& triangles, const RecordedPiece& piece);

}  // namespace brim::exporting
