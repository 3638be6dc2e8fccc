#include "brim/raster/raster_triangles.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/raster/block_rows.h"
#include "brim/raster/triangle_splat.h"

namespace brim {

namespace {

Aabb box_of(std::span<const Vec3> x, const Triangle& t) {
  return {x[t[0]].cwiseMin(x[t[1]]).cwiseMin(x[t[2]]), x[t[0]].cwiseMax(x[t[1]]).cwiseMax(x[t[2]])};
}

/// Densities of a slab around the triangles, and sources.
BRIM_WIDE void settle_sheet(const BlockScratch& scratch, double thickness, double h, double w, DensityBlock& block) {
  const float half = static_cast<float>(0.5 * thickness / h), inverse_w = static_cast<float>(h / w);
  for_wanted_groups(block.octants, [&](int group) BRIM_LAMBDA_INLINE {
    const WideIds nearest = load_wide(scratch.nearest + group);
    const WideFloats near = wide_ramp(wide_root(load_wide(scratch.value + group)) - half, inverse_w);
    const WideFloats rho = nearest < 0 ? wide(0.0f) : near;
    store_group(rho, rho > 0.0f ? nearest : wide(-1), group, block);
  });
}

}  // namespace

void raster_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles, double thickness,
                      std::span<const TileKey> tiles, double h, double w, std::span<DensityBlock> out,
                      RasterWorkspace& workspace) {
  BRIM_CHECK(tiles.size(), ==, out.size());
  const double reach = 0.5 * (thickness + w);
  workspace.index.build(tiles);
  workspace.reach.build(x, triangles, reach);
  workspace.bins.build(workspace.index, tiles.size(), h, BoxList{triangles.size(), [&](std::size_t i) {
                                                                   const Vec3 by = workspace.reach.beyond(i);
                                                                   const Aabb box = box_of(x, triangles[i]);
                                                                   return Aabb{box.lo - by, box.hi + by};
                                                                 }});
  const float far2 = static_cast<float>(reach * reach / (h * h));
  parallel_for(tiles.size(), [&](std::size_t t) {
    BlockScratch scratch;
    std::fill_n(scratch.value, kBlockNodes, far2);
    std::fill_n(scratch.nearest, kBlockNodes, -1);
    splat_triangles(x, triangles, workspace.bins.of(t), {}, workspace.reach, block_origin(tiles[t], h), h,
                    out[t].octants, scratch);
    settle_sheet(scratch, thickness, h, w, out[t]);
  });
}

namespace {

template <class Tile>
void cover_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles, double reach, double h,
                     const Aabb& region, std::vector<Tile>& out, TileCover& cover) {
  Aabb box;
  for (const Triangle& t : triangles) box.extend(box_of(x, t));
  cover.cover(box.inflated(reach).intersection(region), h, out,
              BoxList{triangles.size(), [&](std::size_t i) { return box_of(x, triangles[i]).inflated(reach); }});
}

}  // namespace

void presence_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles, double thickness, double h,
                        double w, const Aabb& region, std::vector<TileKey>& out, RasterWorkspace& workspace) {
  cover_triangles(x, triangles, 0.5 * (thickness + w), h, region, out, workspace.cover);
}

void presence_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles, double thickness, double h,
                        double w, const Aabb& region, std::vector<OctantTile>& out, RasterWorkspace& workspace) {
  cover_triangles(x, triangles, 0.5 * (thickness + w), h, region, out, workspace.cover);
}

}  // namespace brim
