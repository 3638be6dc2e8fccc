#pragma once

#include <algorithm>
#include <cmath>

#include "brim/math/ramp.h"

namespace brim {

template <class Distance>
void fill_block(const Distance& distance, const Pose& pose, const TileKey& tile, double h, double w, DensityBlock& out,
                double slack) {
  std::fill(std::begin(out.source), std::end(out.source), 0);
  const Vec3 origin = block_origin(tile, h);
  const Mat3 back = pose.rotation.transpose();
  const Vec3 base = back * (origin - pose.translation);
  const Vec3 dx = back.col(0) * h, dy = back.col(1) * h, dz = back.col(2) * h;
  const double half = 0.5 * (kBlockSize - 1);
  const double reach = half * h * std::sqrt(3.0) + 0.5 * w + slack;
  const double center = distance(base + half * (dx + dy + dz));
  if (center > reach || center < -reach) {
    std::fill(std::begin(out.rho), std::end(out.rho), center > 0.0 ? 0.0 : 1.0);
    return;
  }
  double* rho = out.rho;
  for (int k = 0; k < kBlockSize; ++k)
    for (int j = 0; j < kBlockSize; ++j) {
      const Vec3 row = base + j * dy + k * dz;
      for (int i = 0; i < kBlockSize;) {
        const double d = distance(row + i * dx);
        rho[i++] = ramp(d, w);
        // A node this far from the surface speaks for those that follow.
        const double away = (std::abs(d) - 0.5 * w - slack) / h;
        for (const int end = std::min(kBlockSize, i + static_cast<int>(std::clamp(away, 0.0, double{kBlockSize})));
             i < end; ++i)
          rho[i] = d > 0.0 ? 0.0 : 1.0;
      }
      rho += kBlockSize;
    }
}

}  // namespace brim
