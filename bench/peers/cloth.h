#pragma once

#include <memory>

#include "pile.h"

namespace brim::peers {

/// A rectangular sheet that falls on a fixed ball, as every engine takes it.
struct ClothOnBall {
  double size_x = 0.0, size_y = 0.0;  ///< [m] of the sheet, level and centred above `start`
  int nodes_x = 0, nodes_y = 0;
  Vec3 start = Vec3::Zero();   ///< [m] centre of the sheet
  Vec3 center = Vec3::Zero();  ///< [m] of the ball
  double radius = 0.0;         ///< [m] of the ball
  double thickness = 0.0;      ///< [m] of the sheet in contact
  double mass = 0.0;           ///< [kg] of the sheet
  double friction = 0.0;       ///< [-]
  double time_step = 0.0;      ///< [s]
};

/// Takes a scene of one gridded cloth and one spherical obstacle apart.
/// @return nothing when the scene is not of that kind
std::unique_ptr<ClothOnBall> cut_cloth(const Scene& scene);

/// A sheet whose nodes can be looked at.
class SheetEngine {
 public:
  virtual ~SheetEngine() = default;
  virtual void step() = 0;
  /// Positions of the nodes of its middle surface, [m], row by row.
  virtual std::vector<Vec3> nodes() const = 0;
};

std::unique_ptr<SheetEngine> make_bullet_cloth(const ClothOnBall& cloth);

/// [m] by which the middle surface of the sheet lies inside the ball at the worst of its nodes and of the middles
/// between neighbours; negative: outside everywhere.
double depth_in_ball(const ClothOnBall& cloth, const std::vector<Vec3>& nodes);

}  // namespace brim::peers
