#pragma once

#include "brim/body/particles/particle_contact.h"
#include "brim/core/workspace_pool.h"
#include "brim/map/sheet_patches.h"
#include "brim/raster/raster_triangles.h"

namespace brim {

/// A sheet: the slab of a given thickness around triangles (raster_triangles), with shell weights: linear and angular
/// momentum of contact are exact. The thickness should be at least two voxels.
class SheetContact final : public ParticleContact {
 public:
  /// @param thickness  [m]
  SheetContact(std::vector<Triangle> triangles, double thickness)
      : triangles_(std::move(triangles)), patches_(triangles_), thickness_(thickness) {}

  double reach() const override { return 0.5 * thickness_; }
  Elements elements() const override { return of(triangles_); }
  bool thin() const override { return true; }
  std::unique_ptr<const ParticleContact> piece(std::span<const std::int32_t> elements) const override;
  void presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                std::vector<TileKey>& out) const override;
  void octant_presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                       std::vector<OctantTile>& out) const override;
  void rasterize(std::span<const Vec3> x, double h, double w, std::span<const TileKey> tiles,
                 std::span<DensityBlock> out) const override;
  void make_map(std::span<const Vec3> x, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;

 private:
  std::vector<Triangle> triangles_;
  SheetPatches patches_;
  double thickness_;
  mutable WorkspacePool<RasterWorkspace> workspace_;
};

}  // namespace brim
