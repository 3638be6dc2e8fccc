#include "brim/raster/raster_triangles.h"

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/math/ramp.h"
#include "brim/raster/triangle_splat.h"

namespace brim {

namespace {

Aabb box_of(std::span<const Vec3> x, const Triangle& t) {
  return {x[t[0]].cwiseMin(x[t[1]]).cwiseMin(x[t[2]]), x[t[0]].cwiseMax(x[t[1]]).cwiseMax(x[t[2]])};
}

}  // namespace

void raster_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles, double thickness,
                      std::span<const TileKey> tiles, double h, double w, std::span<DensityBlock> out,
                      RasterWorkspace& workspace) {
  BRIM_CHECK(tiles.size(), ==, out.size());
  const double reach = 0.5 * (thickness + w);
  workspace.index.build(tiles);
  workspace.bins.build(workspace.index, tiles.size(), h, triangles.size(),
                       [&](std::size_t i) { return box_of(x, triangles[i]).inflated(reach); });
  parallel_for(tiles.size(), [&](std::size_t t) {
    const Vec3 origin = block_origin(tiles[t], h);
    DensityBlock& block = out[t];
    // Until the last loop, rho holds the squared distance.
    std::fill_n(block.rho, kBlockNodes, reach * reach);
    std::fill_n(block.source, kBlockNodes, -1);
    for (const std::int32_t i : workspace.bins.of(t)) {
      const Triangle& c = triangles[i];
      splat_triangle(x[c[0]], x[c[1]], x[c[2]], i, reach, origin, h, block.octants, block.rho, block.source);
    }
    for (int n = 0; n < kBlockNodes; ++n) {
      block.rho[n] = block.source[n] < 0 ? 0.0 : ramp(std::sqrt(block.rho[n]) - 0.5 * thickness, w);
      if (block.rho[n] == 0.0) block.source[n] = -1;
    }
  });
}

void presence_triangles(std::span<const Vec3> x, std::span<const Triangle> triangles, double thickness, double h,
                        double w, const Aabb& region, std::vector<TileKey>& out, RasterWorkspace& workspace) {
  const double reach = 0.5 * (thickness + w);
  Aabb box;
  for (const Triangle& t : triangles) box.extend(box_of(x, t));
  workspace.cover.begin(box.inflated(reach).intersection(region), h);
  workspace.cover.add(triangles.size(), [&](std::size_t i) { return box_of(x, triangles[i]).inflated(reach); });
  workspace.cover.append_to(out);
}

}  // namespace brim
