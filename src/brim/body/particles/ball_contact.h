#pragma once

#include "brim/body/particles/particle_contact.h"
#include "brim/core/workspace_pool.h"
#include "brim/raster/raster_points.h"

namespace brim {

/// Balls: everything within a radius of the particles (raster_points). A ball moves with its particle and rotates about
/// it, six velocities each (BallsMap): momentum and angular momentum of contact are exact. The radius should be at
/// least 1.5 voxels.
class BallContact final : public ParticleContact {
 public:
  /// @param radius  [m] one per particle, or a single one for all
  explicit BallContact(std::vector<double> radius);

  double reach() const override { return largest_; }
  void presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                std::vector<TileKey>& out) const override;
  void octant_presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                       std::vector<OctantTile>& out) const override;
  void rasterize(std::span<const Vec3> x, double h, double w, std::span<const TileKey> tiles,
                 std::span<DensityBlock> out) const override;
  void make_map(std::span<const Vec3> x, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;

 private:
  std::vector<double> radius_;
  double largest_;
  mutable WorkspacePool<RasterWorkspace> workspace_;
};

}  // namespace brim
