#pragma once

#include <algorithm>

#include "brim/mesh/voxel_image.h"

namespace brim::testing {

/// An image of a solid given by its signed distance, as a scanner sees it: intensity 100 inside, 0 outside, linear over
/// a voxel at the surface.
template <class Distance>
VoxelImage scan(const Aabb& box, double step, const Distance& distance) {
  VoxelImage image;
  image.size = ((box.extent() / step).array().ceil().cast<int>() + 1).matrix();
  image.axes = step * Mat3::Identity();
  image.origin = box.lo;
  for (int k = 0; k < image.size.z(); ++k)
    for (int j = 0; j < image.size.y(); ++j)
      for (int i = 0; i < image.size.x(); ++i)
        image.values.push_back(static_cast<float>(
            100.0 * std::clamp(0.5 - distance(image.origin + step * Vec3(i, j, k)) / step, 0.0, 1.0)));
  return image;
}

}  // namespace brim::testing
