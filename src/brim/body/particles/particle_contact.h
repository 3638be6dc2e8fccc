#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "brim/grid/tile.h"
#include "brim/map/map.h"
#include "brim/map/reuse_map.h"
#include "brim/math/types.h"
#include "brim/raster/tile_cover.h"

namespace brim {

/// Contact geometry of a body of particles. One of TetContact (solids), SheetContact, LineContact and BallContact; all
/// use only the particles' current positions x [m], not the forces between them. Functions have the meaning of those of
/// Body. Thread-safe.
class ParticleContact {
 public:
  virtual ~ParticleContact() = default;
  /// Extent of matter beyond the box of the particles, [m].
  virtual double reach() const = 0;
  /// Elements that contain all matter: particles of each, concatenated. Empty when each particle is an element.
  struct Elements {
    std::span<const std::int32_t> node;
    int per_element = 1;
  };
  virtual Elements elements() const { return {}; }
  /// True when the particles lie along a surface or a line: matrices of such bodies are cheap to factor.
  virtual bool thin() const { return false; }
  /// The same for a subset of elements, renumbered from 0 in that order; null when pieces are not supported.
  virtual std::unique_ptr<const ParticleContact> piece(std::span<const std::int32_t> elements) const {
    (void)elements;
    return nullptr;
  }
  virtual void presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                        std::vector<TileKey>& out) const = 0;
  /// Octants that may hold density at their own nodes (OctantPresence).
  virtual void octant_presence(std::span<const Vec3> x, double h, double w, const Aabb& region,
                               std::vector<OctantTile>& out) const = 0;
  virtual void rasterize(std::span<const Vec3> x, double h, double w, std::span<const TileKey> tiles,
                         std::span<DensityBlock> out) const = 0;
  virtual void make_map(std::span<const Vec3> x, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                        std::unique_ptr<Map>& map) const = 0;

 protected:
  template <std::size_t n>
  static Elements of(const std::vector<std::array<std::int32_t, n>>& element) {
    return {{element.empty() ? nullptr : element.front().data(), n * element.size()}, static_cast<int>(n)};
  }
};

}  // namespace brim
