#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/raster/shape.h"
#include "brim/response/moved_rows.h"

namespace brim {

/// The places at which rigid solids are sampled. A solid keeps its reference while no point of it has moved by more
/// than a tenth of a voxel since; what was found there then stays, moved along (RigidContacts). References are part of
/// the world's state, in its memory: a run that is resumed goes on bit for bit.
///   memory: [−1 − k, k times (part, rotation by columns, translation), rows ...]; without references only rows
/// Tests: tests/world/rigid_contacts_test.cpp
class ReferencePoses {
 public:
  /// What a point of a solid may have moved, over the finest step, before it is sampled anew.
  static constexpr double kTolerance = 0.1;

  /// Forgets all. @param parts  how many there are
  void reset(std::size_t parts);
  /// Takes over the references in memory, and forgets all others. @param parts  how many there are
  void restore(std::span<const double> memory, std::size_t parts);
  /// Sees to it that a solid lies within the tolerance of its reference: else it lies there now.
  /// @param local  box of the solid in its own frame  @param reach  [m] its farthest point from its place; 0 where that
  ///               is unknown  @param h  [m] finest step
  void follow(std::size_t part, const Pose& now, const Aabb& local, double reach, double h);

  const Pose& pose(std::size_t part) const { return pose_[part]; }
  /// From the reference to where the solid lies since the last follow.
  const RigidMotion& motion(std::size_t part) const { return motion_[part]; }
  /// A number that changes when the reference does; 0 where there is none.
  std::uint64_t stamp(std::size_t part) const { return stamp_[part]; }

  /// Puts a reference before what memory holds. @param parts  those whose reference is not where they lie
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
