#pragma once

#include <span>
#include <string>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// One image of a series and its geometry, from its header.
struct StackSlice {
  std::string name;                ///< of its file and frame, for messages
  Vec3 position = Vec3::Zero();    ///< [mm] centre of the first pixel
  Vec3 row = Vec3::UnitX();        ///< direction of increasing column index
  Vec3 column = Vec3::UnitY();     ///< direction of increasing row index
  Eigen::Vector2d step{1.0, 1.0};  ///< [mm] between columns (along row), between rows (along column)
  int width = 0, height = 0;       ///< [pixels]
  double thickness = 0.0;          ///< [mm] of the slice, 0 if not given; used as the step of a single slice
};

/// Slices as a volume: pixel (i, j) of slice order[k] lies at origin + axes (i, j, k).
struct SliceStack {
  std::vector<std::size_t> order;  ///< along the normal row × column
  Mat3 axes = Mat3::Identity();    ///< [mm]
  Vec3 origin = Vec3::Zero();      ///< [mm]
  double tilt = 0.0;               ///< [rad] between the third axis and the normal: the gantry tilt, exactly a shear
};

/// Sorts parallel slices by their positions, which also give the step between them.
/// @param whole  name of the stack in messages
/// @throws InputError  with the slices' names, when directions, sizes or steps differ, positions coincide, a slice is
///                     missing, or one is off its even position by more than a tenth of a step
/// Tests: tests/io/slice_stack_test.cpp
SliceStack stack_slices(const std::string& whole, std::span<const StackSlice> slices);

}  // namespace brim
