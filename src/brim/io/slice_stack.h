#pragma once

#include <span>
#include <string>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// One image of a series and where it lies, as its header says.
struct StackSlice {
  std::string name;                ///< of its file, and frame, for messages
  Vec3 position = Vec3::Zero();    ///< [mm] centre of the first pixel
  Vec3 row = Vec3::UnitX();        ///< direction in which the columns of a row follow each other
  Vec3 column = Vec3::UnitY();     ///< direction in which the rows follow each other
  Eigen::Vector2d step{1.0, 1.0};  ///< [mm] between columns (along row), between rows (along column)
  int width = 0, height = 0;       ///< [pixels]
  double thickness = 0.0;          ///< [mm] of the slice, 0 when it does not say; the step of a stack of one
};

/// Slices as a volume: pixel (i, j) of slice order[k] lies at origin + axes (i, j, k).
struct SliceStack {
  std::vector<std::size_t> order;  ///< along the normal row × column
  Mat3 axes = Mat3::Identity();    ///< [mm]
  Vec3 origin = Vec3::Zero();      ///< [mm]
  double tilt = 0.0;               ///< [rad] between the third axis and the normal: a gantry's, and exact as a shear
};

/// Sorts parallel slices by their positions and takes the step between them from these.
/// @param whole  what the slices make up, for messages
/// @throws InputError  with the slices' names, where directions, sizes or steps differ, positions coincide, a slice is
///   missing, or one lies further than a tenth of a step from its even place
/// Tests: tests/io/slice_stack_test.cpp
SliceStack stack_slices(const std::string& whole, std::span<const StackSlice> slices);

}  // namespace brim
