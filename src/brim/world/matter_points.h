#pragma once

#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/world_part.h"

namespace brim {

/// Points of matter of one part, or of space, and where they are as the body moves: what links hold to. They follow
///   a solid's pose            rigid bodies, obstacles, links of trees
///   MaterialPoints            bodies of one's own
///   the node itself           bodies whose nodes move past each other (LooseNodes)
///   J q, J the map at start   other bodies of nodes, whose map is linear in their positions
/// exactly, so that nothing needs to be kept from step to step.  Tests: tests/world/links_test.cpp,
/// matter_points_test.cpp
class MatterPoints {
 public:
  /// True for solids and bodies of one's own: any point may be held, inside or out.
  static bool takes_any(const WorldPart& part);
  /// Of several parts the one whose matter a place belongs to: in whose box it lies or to whose it is nearest, of boxes
  /// that overlap the one whose solid is nearest. @param x  [m]
  static std::size_t nearest_part(std::span<const WorldPart> parts, const Vec3& x);
  /// Points of space. @param x  [m]
  static MatterPoints of_space(std::vector<Vec3> x);
  /// Takes the points of a part where it is now. Solids and bodies of one's own carry any point; other bodies must have
  /// matter within two voxels of it: else the nearest vertex of their display is taken, and a sheet's, a rod's or a
  /// grain's point lies on its middle. Of loose nodes the nearest one is taken. Where several are asked for, those
  /// whose matter is more than two voxels off are replaced by the nearest that is not. @param part  its h must be known
  /// @param w  [m] ramp  @param q  of the body
  /// @throws InputError for fluids on a grid and bodies that have no points to hold
  static MatterPoints of_part(const WorldPart& part, double w, std::span<const double> q, std::vector<Vec3> x);

  std::size_t size() const { return x_.size(); }
  /// Takes the body's last updated state. @param q  of the body
  void follow(const WorldPart& part, std::span<const double> q);
  std::span<const Vec3> positions() const { return x_; }
  /// What make_map takes for point i.
  std::int32_t source(std::size_t i) const { return source_[i]; }
  bool in_space() const { return means_ == Means::Space; }
  /// How much forces have to act at the points themselves. Of the two sides of a link the one that has to more says
  /// where they do.
  ///   0  anywhere does as well     1  points lie on nodes and what joins them     2  points are nodes
  int bound() const { return means_ == Means::Loose ? 2 : means_ == Means::Nodes ? 1 : 0; }
  bool loose() const { return means_ == Means::Loose; }

 private:
  enum class Means { Space, Solid, Material, Loose, Nodes };
  Means means_ = Means::Space;
  std::vector<Vec3> x_;               ///< [m] now
  std::vector<Vec3> local_;           ///< of solids and bodies of one's own
  std::vector<std::int32_t> source_;  ///< of bodies of nodes
  std::shared_ptr<const Map> map_;    ///< likewise, where they are not loose
  std::vector<std::int32_t> node_;    ///< loose ones
};

}  // namespace brim
