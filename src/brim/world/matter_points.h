#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/world_part.h"

namespace brim {

/// [m] The vertices of the body's display that lie in a region, at its last update.
/// @throws InputError  when there are none
std::vector<Vec3> points_in(const Body& body, const std::function<bool(const Vec3&)>& region);

/// Material points of one part, or points of space, that links hold, followed as the body moves. They follow
///   a solid's pose            rigid bodies, obstacles, links of trees
///   MaterialPoints            own bodies (OwnBody)
///   the node itself           bodies whose nodes move past each other (LooseNodes)
///   J q, J the map at start   other bodies of nodes, whose map is linear in their positions
/// exactly, so that nothing needs to be kept from step to step.  Tests: tests/world/links_test.cpp,
/// matter_points_test.cpp
class MatterPoints {
 public:
  /// True for solids and own bodies: any point may be held, inside or out.
  static bool takes_any(const WorldPart& part);
  /// The part that a place belongs to: the one whose box contains it or is nearest; among overlapping boxes, the one
  /// whose solid is nearest. @param x  [m]
  static std::size_t nearest_part(std::span<const WorldPart> parts, const Vec3& x);
  /// Points of space. @param x  [m]
  static MatterPoints of_space(std::vector<Vec3> x);
  /// Takes the points of a part at its present position. Solids and own bodies accept any point. Other bodies hold it
  /// where they have material, else at the material within two voxels of it, else at the nearest vertex of their
  /// display; for sheets, rods and grains the point is projected onto their middle; for loose nodes the nearest node is
  /// taken. If most of several points are held within two voxels, the others are replaced by the nearest that is.
  /// @param part  its h must be known  @param w  [m] ramp  @param q  of the body
  /// @throws InputError for fluids on a grid and bodies that have no points to hold
  static MatterPoints of_part(const WorldPart& part, double w, std::span<const double> q, std::vector<Vec3> x);

  std::size_t size() const { return x_.size(); }
  /// Moves the points to the body's last updated state. @param q  of the body
  void follow(const WorldPart& part, std::span<const double> q);
  std::span<const Vec3> positions() const { return x_; }
  /// Source to pass to make_map for point i.
  std::int32_t source(std::size_t i) const { return source_[i]; }
  bool in_space() const { return means_ == Means::Space; }
  /// How strictly forces must act at the points themselves; of a link's two sides, the stricter one determines where.
  ///   0  anywhere     1  points lie on nodes or between connected ones     2  points are nodes
  int bound() const { return means_ == Means::Loose ? 2 : means_ == Means::Nodes ? 1 : 0; }
  bool loose() const { return means_ == Means::Loose; }

 private:
  enum class Means { Space, Solid, Material, Loose, Nodes };
  Means means_ = Means::Space;
  std::vector<Vec3> x_;               ///< [m] now
  std::vector<Vec3> local_;           ///< for solids and own bodies
  std::vector<std::int32_t> source_;  ///< for bodies of nodes
  std::shared_ptr<const Map> map_;    ///< likewise, unless the nodes are loose
  std::vector<std::int32_t> node_;    ///< for loose nodes
};

}  // namespace brim
