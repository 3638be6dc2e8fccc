#pragma once

#include <algorithm>
#include <cmath>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/math/ramp.h"
#include "brim/raster/raster_triangles.h"

namespace brim {

/// A segment with a radius; a ball when both ends are the same.
struct Capsule {
  Vec3 a, b;
  double radius;
  Aabb box(double w) const { return Aabb{a.cwiseMin(b), a.cwiseMax(b)}.inflated(radius + 0.5 * w); }
};

/// The common part of raster_segments and raster_points. @param capsule_of  capsule_of(i): Capsule
template <class CapsuleOf>
void raster_capsules(std::size_t count, const CapsuleOf& capsule_of, std::span<const TileKey> tiles, double h, double w,
                     std::span<DensityBlock> out, RasterWorkspace& workspace) {
  BRIM_CHECK(tiles.size(), ==, out.size());
  workspace.index.build(tiles);
  workspace.bins.build(workspace.index, tiles.size(), h, count, [&](std::size_t i) { return capsule_of(i).box(w); });
  parallel_for(tiles.size(), [&](std::size_t t) {
    const Vec3 origin = block_origin(tiles[t], h);
    DensityBlock& block = out[t];
    // Until the last loop, rho holds the signed distance.
    std::fill_n(block.rho, kBlockNodes, 0.5 * w);
    std::fill_n(block.source, kBlockNodes, -1);
    for (const std::int32_t id : workspace.bins.of(t)) {
      const Capsule c = capsule_of(static_cast<std::size_t>(id));
      const NodeRange n = nodes_in_box(c.box(w), origin, h, block.octants);
      const Vec3 ab = c.b - c.a;
      const double inverse = ab.squaredNorm() > 0.0 ? 1.0 / ab.squaredNorm() : 0.0;
      for (int k = n.lo[2]; k <= n.hi[2]; ++k)
        for (int j = n.lo[1]; j <= n.hi[1]; ++j)
          for (int i = n.lo[0]; i <= n.hi[0]; ++i) {
            const Vec3 ar = origin + h * Vec3(i, j, k) - c.a;
            const double s = std::clamp(ar.dot(ab) * inverse, 0.0, 1.0);
            const double d = (ar - s * ab).norm() - c.radius;
            const int node = block_index(i, j, k);
            if (d < block.rho[node]) block.rho[node] = d, block.source[node] = id;
          }
    }
    for (int n = 0; n < kBlockNodes; ++n) {
      block.rho[n] = block.source[n] < 0 ? 0.0 : ramp(block.rho[n], w);
      if (block.rho[n] == 0.0) block.source[n] = -1;
    }
  });
}

template <class CapsuleOf>
void presence_capsules(std::size_t count, const CapsuleOf& capsule_of, double h, double w, const Aabb& region,
                       std::vector<TileKey>& out, RasterWorkspace& workspace) {
  Aabb box;
  for (std::size_t i = 0; i < count; ++i) box.extend(capsule_of(i).box(w));
  workspace.cover.begin(box.intersection(region), h);
  workspace.cover.add(count, [&](std::size_t i) { return capsule_of(i).box(w); });
  workspace.cover.append_to(out);
}

}  // namespace brim
