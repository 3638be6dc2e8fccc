#pragma once

#include <array>

#include "brim/body/particles/particle_contact.h"
#include "brim/core/workspace_pool.h"
#include "brim/raster/raster_segments.h"

namespace brim {

/// Lines: everything within a radius of segments (raster_segments), with line weights: linear momentum of contact is
/// exact, angular momentum except for the spin of a line about itself (LineWeightsMap). The radius should be at least
/// one voxel.
class LineContact final : public ParticleContact {
 public:
  using Segment = std::array<std::int32_t, 2>;
  /// @param radius  [m]
  LineContact(std::vector<Segment> segments, double radius) : segments_(std::move(segments)), radius_(radius) {}

  double reach() const override { return radius_; }
  Elements elements() const override { return of(segments_); }
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
  std::vector<Segment> segments_;
  double radius_;
  mutable WorkspacePool<RasterWorkspace> workspace_;
};

}  // namespace brim
