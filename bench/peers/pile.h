#pragma once

#include <memory>
#include <string>
#include <vector>

#include "brim/math/types.h"
#include "brim/scene/scene.h"

namespace brim::peers {

/// A convex piece of a solid: the hull of points [m], inflated by a radius [m]. One point makes a ball, two make a
/// capsule; a box about the origin says its half edges instead.
struct Piece {
  std::vector<Vec3> points;
  double radius = 0.0;
  Vec3 half = Vec3::Zero();  ///< [m] of a box; zero: not a box

  bool box() const { return half != Vec3::Zero(); }
  bool ball() const { return points.size() == 1; }
  bool capsule() const { return points.size() == 2; }
  double reach() const;  ///< [m] farthest matter from the origin
};

/// A rigid body as every engine takes it; its frame has its origin at the centre of mass and principal axes.
struct Solid {
  int shape = 0;  ///< index into Pile::shapes
  Vec3 position = Vec3::Zero();
  Quat rotation = Quat::Identity();
  double mass = 0.0;            ///< [kg]
  Vec3 inertia = Vec3::Zero();  ///< [kg m²]
};

/// A wall: a fixed box.
struct Wall {
  Vec3 center, half;
};

/// The pile of a brim scene, for engines that know convex pieces only.
struct Pile {
  std::vector<std::vector<Piece>> shapes;
  std::vector<Solid> solids;
  std::vector<Wall> walls;  ///< besides the floor z = 0
  double time_step = 0.0;   ///< [s]
  double friction = 0.0;    ///< [-]
};

/// Takes a scene of rigid boxes, balls, gears, stars and tori, of box obstacles and of the plane z = 0 apart.
/// Boxes and balls are what they are. Gears and stars are cut into prisms and rings into capsules: exact but for the
/// chords of bores and of rings, which miss the circle by 2 % of the bore and by 1 % of the ring's radius.
/// @throws InputError  for anything else
Pile cut_pile(const Scene& scene, const World& world);

/// Position and rotation of each solid, and the largest speed of any matter.
struct Placement {
  std::vector<Vec3> position;
  std::vector<Quat> rotation;
  std::vector<Vec3> velocity, spin;  ///< [m/s], [rad/s], world frame
};

class Engine {
 public:
  virtual ~Engine() = default;
  virtual std::string name() const = 0;
  /// One step of Pile::time_step, on the calling thread alone.
  virtual void step() = 0;
  virtual Placement placement() const = 0;
};

/// @param start  where the solids start, at rest, instead of the scene's own placement and speeds, or null
std::unique_ptr<Engine> make_brim(const Scene& scene, const Pile* start = nullptr);
/// @param sleep  let bodies at rest fall asleep, as Bullet does when nothing is said
std::unique_ptr<Engine> make_bullet(const Pile& pile, bool sleep);
#ifdef BRIM_PEER_MUJOCO
/// @param solver  "Newton", which MuJoCo takes when nothing is said, "CG" or "PGS"
/// Most contacts that are kept: 16 a solid.
std::unique_ptr<Engine> make_mujoco(const Pile& pile, const std::string& solver);
#endif

/// Overlap of a placement, measured the same way for every engine: brim's densities of all bodies at the scene's
/// voxels, −(d_a + d_b) where two of them share a node, in metres.
struct Overlap {
  double worst = 0.0;  ///< [m]
  double mean = 0.0;   ///< [m] of the pairs that touch, each at its deepest
  int pairs = 0;       ///< that touch
};
Overlap measure_overlap(World& world, const Placement& placement);

}  // namespace brim::peers
