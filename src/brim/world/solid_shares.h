#pragma once

#include <map>
#include <utility>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/grid/tile.h"
#include "brim/raster/shape.h"
#include "brim/world/world_part.h"

namespace brim {

class PosedShape;

/// A solid's share of an eighth of a cell of a fluid's grid.
struct Eighth {
  std::int32_t place;         ///< index in the grid of eighths, x fastest, shape (2 nx, 2 ny, 2 nz)
  float share;                ///< (0, 1]
  std::int32_t source;        ///< source for the maps of its body
  Vec3f off = Vec3f::Zero();  ///< [eighths] from the eighth's middle to that of the solid in it
};

/// The eighths of cells occupied by solids. Solids are rasterized on a grid of eighths, whose densities give the
/// distance near the surface; shapes with a known distance are evaluated directly, and only when they have moved. For
/// what is thinner than three eighths these are divided.
/// Same bits for any number of threads.  Tests: tests/world/fluid_coupling_test.cpp
class SolidShares {
 public:
  /// The occupied eighths of a fluid's cells; valid until the next call for the same two parts.
  /// @param two  numbers of the fluid part and the solid part
  const std::vector<Eighth>& of(std::pair<std::int32_t, std::int32_t> two, const MacGrid& grid, const WorldPart& solid);
  void clear() { found_.clear(); }

 private:
  struct Found {
    const Body* body = nullptr;
    Vec3 origin = Vec3::Zero();  ///< [m] of the fluid's grid
    Pose pose;
    std::vector<Eighth> eighths;
  };
  /// @param solid  the part as a shape, or null
  void sample(const MacGrid& grid, const WorldPart& part, const PosedShape* solid, std::vector<Eighth>& out);

  std::map<std::pair<std::int32_t, std::int32_t>, Found> found_;
  std::vector<TileKey> tiles_;
  std::vector<DensityBlock> blocks_;
};

}  // namespace brim
