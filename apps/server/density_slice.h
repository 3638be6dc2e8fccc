#pragma once

#include <cstdint>
#include <vector>

#include "brim/core/error.h"
#include "brim/world/world.h"

namespace brim::viewer {

/// A request whose answer would take too long.
class TooMuchWork : public InputError {
 public:
  using InputError::InputError;
};

/// Which plane of nodes to look at.
struct SliceRequest {
  int axis = 2;       ///< across the plane: 0 x, 1 y, 2 z
  double at = 0.0;    ///< [m] along the axis; the nearest layer of nodes is taken
  int body = -1;      ///< densities of this body only; -1: of all
  double step = 0.0;  ///< [m] grid step, from a quarter of the finest that a part asks for; 0: the finest
};

/// The nodes of a plane. Node (i, j) lies at step * (first[0] + i, first[1] + j) along the two other axes, in the order
/// x y, y z or z x that makes a right-handed frame with the axis.
struct DensitySlice {
  int axis = 2;
  double at = 0.0;                     ///< [m] of the layer taken
  double step = 0.0;                   ///< [m]; coarser than asked for where the plane would have too many nodes
  double lowest = 0.0, highest = 0.0;  ///< [m] along the axis: where there is something to see
  std::int32_t first[2] = {0, 0};
  std::int32_t count[2] = {0, 0};
  std::vector<float> density;      ///< of the body that fills the node most, [-], shape (count[1], count[0])
  std::vector<std::int32_t> body;  ///< that body, -1 where there is none
  std::vector<float> second;       ///< of the body that fills it second most
  std::vector<std::int32_t> second_body;
  std::vector<float> overlap;  ///< max(0, ρ_a + ρ_b − 1) of the two parts that overlap most; of two bodies, or
                               ///< of two parts of one body that collide
};

inline constexpr std::size_t kMostTiles = 30000;

/// Densities as contact sees them, on one plane through everything that can move (docs/viewer.md).
/// Cost: that of rasterizing the tiles that the plane meets, at most kMostTiles of all parts together: where they are
/// more, a step that was not asked for is doubled. @throws InputError  for an axis or body that is not there
/// @throws TooMuchWork  for a step that is asked for and too fine
/// Tests: tests/server/density_slice_test.cpp
DensitySlice cut_densities(const World& world, const SliceRequest& request);

}  // namespace brim::viewer
