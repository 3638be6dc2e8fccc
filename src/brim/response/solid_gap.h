#pragma once

#include <vector>

#include "brim/contact/cube_contacts.h"
#include "brim/math/types.h"
#include "brim/raster/convex_distance.h"
#include "brim/response/moved_rows.h"

namespace brim {

/// Rows between two convex solids, read from their distances between the nodes of the grid. Nodes say where two solids
/// touch; next to an edge or a corner none need lie where the gap is least, and what they say there is up to half a
/// voxel too large. So both distances are read off the grid, with a parted from b along the normal n by s, so far that
/// there is room between them:
///   φ = min over x of d_a(x − s n) + d_b(x) − s n·m
/// There the sum is convex, its least value is the distance between the parted solids, and m, its normal, is read off
/// the gradients. Then a is parted along m. The minimum across n is found by cutting planes and the curvature that
/// differences of gradients tell: Newton's step where surfaces are smooth, the kink where one has an edge.
/// Where both surfaces are flat in some direction, rows stand at the ends of what touches: from the least gap the way
/// goes on until the sum leaves its tangent, and along the edge that is found there until it does so again.
/// Tests: tests/response/solid_gap_test.cpp
class SolidGap {
 public:
  /// @param h  [m] grid step
  SolidGap(const CubeSide& a, const CubeSide& b, double h);
  /// False where a solid does not tell its distance so.
  bool reads() const { return distance_a_ != nullptr && distance_b_ != nullptr; }

  /// A place near the least gap, with its normal and the gap there, by projections to both solids in turn.
  /// @param region  [m] what may touch lies there  @param most  [m]
  /// @return false where the gap is more than that: the sum of the distances is convex, and never less than its tangent
  bool approach(const Aabb& region, double most, RowPoint& near);
  /// Appends the rows of the two solids: the least gap, or the ends of what touches.
  /// @param near  a place near the least gap; its gap is the sum of the distances there, its normal is a guess
  /// @param widest  [m] gap above which there are no rows
  /// @return false where no common normal near that one is found
  bool find_rows(const RowPoint& near, double widest, std::vector<RowPoint>& rows);
  /// Takes a row to the least gap within a reach of it, [m]: place, normal, gap and curvatures.
  bool find_least(RowPoint& row, double reach);
  /// Distances read so far, of both solids together.
  std::int64_t readings() const { return readings_; }

 private:
  struct Reading {
    Vec3 x;                   ///< [m] between the parted solids
    double a = 0.0, b = 0.0;  ///< [m] distances
    Vec3 away_a, away_b;
    double sum() const { return a + b; }
    Vec3 slope() const { return away_a + away_b; }
  };
  using Mat2 = Eigen::Matrix2d;
  using Vec2 = Eigen::Vector2d;
  static constexpr double kOneEnd = 0.75;  ///< [h] ends nearer to each other are one
  Reading read(const Vec3& x) const;
  /// Reading at a row's place, with a parted from b as far as it takes, and by more, [m].
  Reading part_at(const RowPoint& row, double more);
  /// Curvatures of both distances across the normal, by differences of gradients, [1/m].
  void bend(const Reading& r, Mat2& a, Mat2& b) const;
  /// Reading of the least sum within a reach across the normal.
  Reading descend(const Reading& first, const Mat2& curvature, double reach) const;
  /// A place on an edge, and the direction along it, both across the normal.
  struct Edge {
    Vec3 x, along;
  };
  /// Goes from a place along a way to where the sum leaves the tangent that `flat` has, and finds the edge there.
  /// @param way  unit, across the normal
  bool walk(const Reading& flat, const Vec3& from, const Vec3& way, Edge& edge) const;
  /// Notes the ends of what touches around the least gap.
  void find_ends(const RowPoint& least);
  /// Turns a direction from the least gap, at one end of an edge, to where the edge goes.
  /// @return false where no edge goes there with hardly a rise  @param ring  found on it
  bool find_valley(double& angle, Reading& ring) const;
  /// Notes the two ends of an edge. @return its middle
  Vec3 add_edge(const Reading& flat, const Edge& edge, const RowPoint& like);
  /// @param like  its normal and curvatures are the end's
  void add_end(const Reading& flat, const Vec3& x, const RowPoint& like);
  /// Lets friction at the ends act where its torque is that of an even pressure (friction_radius.h).
  void place_friction(const Vec3& normal);
  /// True where nothing but one place touches: the gap is bent alike in all directions.
  bool round(const RowPoint& least) const;

  const ConvexDistance *distance_a_, *distance_b_;
  Pose pose_a_, pose_b_;
  double h_;
  mutable std::int64_t readings_ = 0;
  /// Parted solids and what is found there.
  struct Parting {
    Vec3 normal = Vec3::UnitZ(), part = Vec3::Zero();  ///< [m] displacement of a along the normal
    Eigen::Matrix<double, 3, 2> across;                ///< tangents of the normal
    Reading least;
  };
  Parting parting_;
  std::vector<RowPoint> ends_;
  Reading face_;  ///< on what is flat in both directions
  bool face_found_ = false;
};

}  // namespace brim
