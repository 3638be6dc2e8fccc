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

/// What a solid has of an eighth of a cell of a fluid's grid.
struct Eighth {
  std::int32_t place;   ///< of the grid's eighths, x fastest, shape (2 nx, 2 ny, 2 nz)
  float share;          ///< (0, 1]
  std::int32_t source;  ///< as its body's maps ask for it
};

/// The eighths of cells that solids lie in. Their densities on a grid of eighths tell the distance to the surface near
/// it; what is known everywhere, a shape in a place, is asked itself, and only where it has moved since.
/// Same bits for any number of threads.  Tests: tests/world/fluid_coupling_test.cpp
class SolidShares {
 public:
  /// Eighths of a fluid's cells that a solid has something of, until the next call for the same two.
  /// @param two  numbers of the parts that are fluid and solid
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
