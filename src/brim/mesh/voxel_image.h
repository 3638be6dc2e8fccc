#pragma once

#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Raw volume data: intensities at the centres of voxels, and the geometry of the voxels.
///   x(i, j, k) = origin + axes (i, j, k)ᵀ
struct VoxelImage {
  Vec3i size = Vec3i::Zero();    ///< voxels along i, j, k
  Mat3 axes = Mat3::Identity();  ///< [m] columns: step to the next voxel along i, j, k; any angles, any handedness
  Vec3 origin = Vec3::Zero();    ///< [m] centre of voxel (0, 0, 0)
  std::vector<float> values;     ///< shape (nk, nj, ni), i fastest

  std::size_t count() const {
    return static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(size.z());
  }
  /// Bounding box of all voxels at full extent, [m].
  Aabb box() const;
  /// Shortest of the three steps, [m].
  double finest_step() const { return axes.colwise().norm().minCoeff(); }
  /// Trilinear value at a position in voxels; within half a voxel of the border the border's value.
  /// @return false outside the image; value is then unchanged
  bool sample(const Vec3& index, double& value) const;
};

/// Intensity window of matter: intensities from `lo` (empty) to `hi` (full) map linearly to the filled fraction of a
/// voxel; lo = hi is a threshold.
struct IntensityWindow {
  double lo = 0.5, hi = 0.5;
  double share(double intensity) const {
    if (intensity <= lo) return intensity < lo || hi > lo ? 0.0 : 1.0;
    return intensity >= hi ? 1.0 : (intensity - lo) / (hi - lo);
  }
};

}  // namespace brim
