#pragma once

#include <algorithm>
#include <bit>
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
  // Fills n nodes a side from (i0, j0, k0) on.
  const auto fill = [&](int i0, int j0, int k0, int n) {
    const double half = 0.5 * (n - 1);
    const double reach = half * h * std::sqrt(3.0) + 0.5 * w + slack;
    const double center = distance(base + (i0 + half) * dx + (j0 + half) * dy + (k0 + half) * dz);
    const bool far = center > reach || center < -reach;
    for (int k = k0; k < k0 + n; ++k)
      for (int j = j0; j < j0 + n; ++j) {
        double* rho = out.rho + block_index(0, j, k);
        if (far) {
          std::fill(rho + i0, rho + i0 + n, center > 0.0 ? 0.0 : 1.0);
          continue;
        }
        const Vec3 row = base + j * dy + k * dz;
        for (int i = i0; i < i0 + n;) {
          const double d = distance(row + i * dx);
          rho[i++] = ramp(d, w);
          // A node this far from the surface determines those that follow.
          const double away = (std::abs(d) - 0.5 * w - slack) / h;
          for (const int end = std::min(i0 + n, i + static_cast<int>(std::clamp(away, 0.0, double{kBlockSize})));
               i < end; ++i)
            rho[i] = d > 0.0 ? 0.0 : 1.0;
        }
      }
  };
  // An octant with its ring has 216 nodes, the block 1000.
  constexpr int kOctant = kTileSize / 2, kMostOctants = 4;
  if (std::popcount(out.octants) > kMostOctants) return fill(0, 0, 0, kBlockSize);
  std::fill(std::begin(out.rho), std::end(out.rho), 0.0);
  for (int o = 0; o < 8; ++o)
    if (out.octants >> o & 1) fill(kOctant * (o & 1), kOctant * (o >> 1 & 1), kOctant * (o >> 2), kOctant + 2 * kHalo);
}

}  // namespace brim
