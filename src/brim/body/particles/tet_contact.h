#pragma once

#include "brim/body/body.h"
#include "brim/body/particles/element_fallback.h"
#include "brim/body/particles/particle_contact.h"
#include "brim/core/workspace_pool.h"
#include "brim/raster/raster_tets.h"

namespace brim {

/// A solid of tetrahedra: the band method (raster_tets) with barycentric weights, extrapolated outside: linear and
/// angular momentum of contact are exact.
class TetContact final : public ParticleContact {
 public:
  explicit TetContact(const TetMesh& mesh);

  double reach() const override { return 0.0; }
  Elements elements() const override { return of(tets_); }
  void presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                std::vector<TileKey>& out) const override;
  void octant_presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                       std::vector<OctantTile>& out) const override;
  void rasterize(std::span<const Vec3> x, double h, double w, std::span<const TileKey> tiles,
                 std::span<DensityBlock> out) const override;
  void make_map(std::span<const Vec3> x, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;

  std::span<const Triangle> surface() const { return surface_; }
  /// Voxel size: half a boundary edge; areal mass: that of the column along the longest extent; and the thickness.
  /// @param volume  [m³]  @param density  [kg/m³]
  PartInfo part_info(std::span<const Vec3> x, double volume, double density) const;

 private:
  TetSolid solid(std::span<const Vec3> x) const { return {x, tets_, surface_, owner_, &groups_}; }

  std::vector<Tetrahedron> tets_;
  ElementFallback<4> fallback_;
  std::vector<Triangle> surface_;
  std::vector<std::int32_t> owner_;
  TetGroups groups_;
  mutable WorkspacePool<TetRasterWorkspace> workspace_;
};

}  // namespace brim
