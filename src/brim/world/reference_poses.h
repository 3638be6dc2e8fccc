#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/raster/shape.h"
#include "brim/response/moved_rows.h"

namespace brim {

/// Reference poses at which rigid solids are sampled. A solid keeps its reference while none of its points has moved by
/// more than a tenth of a voxel since; results found there stay valid and are moved along (RigidContacts). References
/// are part of the world's state, in its memory, so that a resumed run continues bit for bit.
///   memory: [−1 − k, k times (part, rotation by columns, translation), rows ...]; without references only rows
/// Tests: tests/world/rigid_contacts_test.cpp
class ReferencePoses {
 public:
  /// Largest displacement of a point of a solid, over the finest step, before it is sampled anew.
  static constexpr double kTolerance = 0.1;

  /// Clears all references. @param parts  their number
  void reset(std::size_t parts);
  /// Replaces all references by those in memory. @param parts  their number
  void restore(std::span<const double> memory, std::size_t parts);
  /// Keeps a solid within the tolerance of its reference: sets the reference to the present pose when it is not.
  /// @param local  box of the solid in its own frame  @param reach  [m] distance of its farthest point from its origin;
  ///               0 if unknown  @param h  [m] finest step
  void follow(std::size_t part, const Pose& now, const Aabb& local, double reach, double h);

  const Pose& pose(std::size_t part) const { return pose_[part]; }
  /// Motion from the reference to the solid's pose at the last follow.
  const RigidMotion& motion(std::size_t part) const { return motion_[part]; }
  /// Changes whenever the reference does; 0 when there is none.
  std::uint64_t stamp(std::size_t part) const { return stamp_[part]; }

  /// Writes references in front of memory. @param parts  those whose reference differs from their pose
  void keep(std::span<const std::int32_t> parts, std::vector<double>& memory) const;
  /// The part of memory that holds rows.
  static std::span<const double> rows_of(std::span<const double> memory);

 private:
  std::vector<Pose> pose_;
  std::vector<RigidMotion> motion_;
  std::vector<std::uint64_t> stamp_;
  std::uint64_t last_stamp_ = 0;
};

}  // namespace brim
