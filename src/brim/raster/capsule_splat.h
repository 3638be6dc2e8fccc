#pragma once

#include <algorithm>
#include <vector>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/raster/block_rows.h"
#include "brim/raster/raster_triangles.h"

namespace brim {

/// A segment with a radius; a ball when both ends are the same.
struct Capsule {
  Vec3 a, b;
  double radius;
  Aabb box(double w) const { return Aabb{a.cwiseMin(b), a.cwiseMax(b)}.inflated(radius + 0.5 * w); }
};

/// Nearest capsule of each node of a block: lowers scratch.value, the signed distance in voxels, and sets
/// scratch.nearest where a capsule is closer than the present value; of equals the first stays. Eight nodes at a time
/// in single precision: error at most 2e-6 voxels and 2e-7 of the capsule's length.
/// @param ids     number of each capsule in scratch.nearest, shape (capsules)
/// @param origin  [m] first node of the block  @param h, w  [m] step, ramp width  @param wanted  octants needed
void splat_capsules(std::span<const Capsule> capsules, std::span<const std::int32_t> ids, const Vec3& origin, double h,
                    double w, Octants wanted, BlockScratch& scratch);
/// Computes densities and sources from those distances.
void settle_capsules(const BlockScratch& scratch, double h, double w, DensityBlock& block);

/// The common part of raster_segments and raster_points. @param capsule_of  capsule_of(i): Capsule
template <class CapsuleOf>
void raster_capsules(std::size_t count, const CapsuleOf& capsule_of, std::span<const TileKey> tiles, double h, double w,
                     std::span<DensityBlock> out, RasterWorkspace& workspace) {
  BRIM_CHECK(tiles.size(), ==, out.size());
  workspace.index.build(tiles);
  workspace.bins.build(workspace.index, tiles.size(), h,
                       BoxList{count, [&](std::size_t i) { return capsule_of(i).box(w); }});
  const auto far = static_cast<float>(0.5 * w / h);
  parallel_for(tiles.size(), [&](std::size_t t) {
    BlockScratch scratch;
    std::fill_n(scratch.value, kBlockNodes, far);
    std::fill_n(scratch.nearest, kBlockNodes, -1);
    const std::span<const std::int32_t> ids = workspace.bins.of(t);
    std::vector<Capsule> near;
    near.reserve(ids.size());
    for (const std::int32_t id : ids) near.push_back(capsule_of(static_cast<std::size_t>(id)));
    splat_capsules(near, ids, block_origin(tiles[t], h), h, w, out[t].octants, scratch);
    settle_capsules(scratch, h, w, out[t]);
  });
}

template <class CapsuleOf, class Tile>
void presence_capsules(std::size_t count, const CapsuleOf& capsule_of, double h, double w, const Aabb& region,
                       std::vector<Tile>& out, RasterWorkspace& workspace) {
  Aabb box;
  for (std::size_t i = 0; i < count; ++i) box.extend(capsule_of(i).box(w));
  workspace.cover.cover(box.intersection(region), h, out,
                        BoxList{count, [&](std::size_t i) { return capsule_of(i).box(w); }});
}

}  // namespace brim
