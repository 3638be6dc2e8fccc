#pragma once

#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "brim/body/particle_fluid/fluid_kernel.h"
#include "brim/body/particle_fluid/fluid_map.h"
#include "brim/body/particles/particle_cells.h"
#include "brim/core/workspace_pool.h"
#include "brim/grid/tile.h"
#include "brim/raster/tile_bins.h"
#include "brim/raster/tile_cover.h"

namespace brim {

/// Density and map of a particle fluid on the grid.
///   ρ(r) = (Σ_p V_p W(r − x_p) − 0.09) / 0.91 within [0, 1],   V_p = V max(1, 0.7/φ_p)
/// ρ = 1/2 lies half a spacing outside the outermost particles of a body of fluid. Particles with few neighbours count
/// more than their volume, so that contact also sees a single drop as solid: at its centre ρ = 0.67.
/// The kernel is narrow on purpose: the layer at a wall carries the wall's pressure, and the map must resolve it. With
/// steps h of half the spacing a pool stays at rest; at the whole spacing the roughness of the particles on the grid
/// stirs it, above that it leaks.
class FluidContact {
 public:
  /// @param volume  [m³] of a particle
  FluidContact(const FluidKernel& kernel, double volume) : kernel_(kernel), volume_of_one_(volume) {}
  /// Sets the particles for the following calls. @param fill  φ in cell order
  void begin(const ParticleCells& cells, std::span<const double> fill);

  /// Clears the nodes of earlier calls of rasterize; the particles stay.
  void forget_nodes() { batches_.clear(); }

  void presence(double h, const Aabb& region, std::vector<TileKey>& out) const;
  void rasterize(double h, std::span<const TileKey> tiles, std::span<DensityBlock> out) const;
  /// @param sources  as written by rasterize since the last begin
  void make_map(std::span<const std::int32_t> sources, FluidMap& map) const;

 private:
  struct Batch {  ///< tiles of one call of rasterize; a node's source is first_source + 1000 tile + node
    std::int32_t first_source;
    double h;
    std::vector<TileKey> tiles;
  };
  struct Workspace {
    TileCover cover;
    TileIndex index;
    TileBins bins;
  };
  Vec3 node_of(std::int32_t source) const;

  const ParticleCells* cells_ = nullptr;
  FluidKernel kernel_;
  double volume_of_one_;
  std::vector<double> volume_;                       ///< V_p in cell order, [m³]
  std::shared_ptr<const std::vector<Vec3>> places_;  ///< of the particles in the caller's order, for maps
  mutable std::mutex mutex_;
  mutable std::vector<Batch> batches_;
  mutable WorkspacePool<Workspace> workspace_;
};

}  // namespace brim
