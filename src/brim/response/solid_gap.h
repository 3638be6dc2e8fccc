#pragma once

#include <array>
#include <vector>

#include "brim/contact/cube_contacts.h"
#include "brim/math/types.h"
#include "brim/raster/convex_distance.h"
#include "brim/response/moved_rows.h"

namespace brim {

/// Rows between two convex solids, from their distances between the grid nodes. Nodes find where two solids touch, but
/// next to an edge or a corner no node need lie at the smallest gap, and the gap read there is up to half a voxel too
/// large. So both distances are evaluated off the grid, with a displaced from b along the normal n by s, far enough to
/// leave room between them:
///   φ = min over x of d_a(x − s n) + d_b(x) − s n·m
/// There the sum is convex, its minimum is the distance between the displaced solids, and the gradients give its normal
/// m. Then a is displaced along m. The minimum over tangential x is found by cutting planes plus the curvature from
/// differences of gradients: Newton steps on smooth surfaces, the kink at an edge.
/// Where both surfaces are flat in some direction, rows stand at the ends of the contact region: the search walks from
/// the smallest gap until the sum leaves its tangent, and then along the edge found there until it does so again.
/// Tests: tests/response/solid_gap_test.cpp
class SolidGap {
 public:
  /// @param h  [m] grid step
  SolidGap(const CubeSide& a, const CubeSide& b, double h);
  /// False when a solid has no such distance function (ConvexDistance).
  bool reads() const { return distance_a_ != nullptr && distance_b_ != nullptr; }

  /// A point near the smallest gap with its normal and gap, by alternating projections onto the two solids.
  /// @param region  [m] box of the possible contact  @param most  [m] largest gap of interest
  /// @return false when the gap exceeds `most`: the sum of the distances is convex, and never below its tangent
  bool approach(const Aabb& region, double most, RowPoint& near);
  /// Appends the rows of the two solids: the smallest gap, or the ends of the contact region.
  /// @param near  a point near the smallest gap; its gap is the sum of the distances there, its normal a guess
  /// @param widest  [m] gap above which there are no rows
  /// @return false when no common normal near that one is found
  bool find_rows(const RowPoint& near, double widest, std::vector<RowPoint>& rows);
  /// Moves a row to the smallest gap within a reach of it, [m]: sets point, normal, gap and curvatures.
  bool find_least(RowPoint& row, double reach);
  /// Number of distance evaluations so far, of both solids together.
  std::int64_t readings() const { return readings_; }

 private:
  struct Reading {
    Vec3 x;                   ///< [m] between the displaced solids
    double a = 0.0, b = 0.0;  ///< [m] distances
    Vec3 away_a, away_b;
    double sum() const { return a + b; }
    Vec3 slope() const { return away_a + away_b; }
  };
  using Mat2 = Eigen::Matrix2d;
  using Vec2 = Eigen::Vector2d;
  static constexpr double kOneEnd = 0.75;  ///< [h] ends closer to each other than this are merged
  static constexpr double kTooFar = 0.3;  ///< [h] difference from the smallest gap beyond which an end needs no row yet
  Reading read(const Vec3& x) const;
  /// Moves a point to the closest points of the two solids, where projections come to them slowly.
  void approach_long(RowPoint& near) const;
  /// Reading at a row's point, with a displaced from b as far as needed plus `more`, [m].
  Reading part_at(const RowPoint& row, double more);
  /// Tangential curvatures of both distances, by differences of gradients, [1/m].
  void bend(const Reading& r, Mat2& a, Mat2& b) const;
  /// Reading of the smallest sum within a tangential reach.
  Reading descend(const Reading& first, const Mat2& curvature, double reach) const;
  /// From where a descent ended to the minimum, by Newton's steps along the directions in which the sum is bent: a ball
  /// two steps wide, pressed 0.006 h beside its lowest point, would start to roll on a level box.
  Reading settle(Reading r, const Mat2& bend) const;
  /// A point on an edge and the tangential direction along it.
  struct Edge {
    Vec3 x, along;
  };
  /// Walks from a point in a direction until the sum leaves the tangent plane of `flat`, and finds the edge there.
  /// @param way  unit, tangential
  bool walk(const Reading& flat, const Vec3& from, const Vec3& way, Edge& edge) const;
  /// Stores the ends of the contact region around the smallest gap.
  void find_ends(const RowPoint& least);
  /// Turns a direction from the smallest gap, at one end of an edge, to follow the edge.
  /// @return false when no edge leads away with hardly any rise  @param ring  reading on it
  bool find_valley(double& angle, Reading& ring) const;
  /// Stores the two ends of an edge. @return its middle
  Vec3 add_edge(const Reading& flat, const Edge& edge, const RowPoint& like);
  /// Adds points to the left and right of a face that is wider in its middle than at the edges found at two opposite
  /// sides, and merges the ends of those where they are close, as on a round rim.
  /// @param middles  of the two edges  @param of_first  number of ends of the first  @param like  as in add_end
  void add_sides(const Reading& face, const std::array<Vec3, 2>& middles, std::size_t of_first, const RowPoint& like);
  /// @param like  row whose normal and curvatures the end gets
  void add_end(const Reading& flat, const Vec3& x, const RowPoint& like);
  /// Moves the friction points of the ends so that their torque is that of an even pressure (friction_radius.h).
  void place_friction(const Vec3& normal);
  /// True for a single point of contact: the gap is curved about equally in all directions, and rises accordingly up to
  /// kTooFar.
  bool round(const RowPoint& least) const;

  const ConvexDistance *distance_a_, *distance_b_;
  Pose pose_a_, pose_b_;
  double h_;
  double farthest_;  ///< [m] of the smallest gap from a point near it
  mutable std::int64_t readings_ = 0;
  /// Displaced solids and the results there.
  struct Parting {
    Vec3 normal = Vec3::UnitZ(), part = Vec3::Zero();  ///< [m] displacement of a along the normal
    Eigen::Matrix<double, 3, 2> across;                ///< tangents of the normal
    Reading least;
    Vec3 rest = Vec3::Zero();  ///< [m] from there to the minimum
  };
  Parting parting_;
  std::vector<RowPoint> ends_;
  Reading face_;  ///< on a face, flat in both directions
  bool face_found_ = false;
};

}  // namespace brim
