#pragma once

#include <array>

#include "brim/contact/cube_contacts.h"

namespace brim {

/// Points searched together: about 20 kB, which fits a first-level cache.
inline constexpr int kTogether = 64;

/// Data of up to kTogether points.
using Numbers = std::array<double, kTogether>;
using Vectors = std::array<Numbers, 3>;

/// Points, the search direction of each, the direction across it on the face, and the gap at each, [m].
struct Search {
  Vectors x, e, f;
  Numbers level;
  int n = 0;
  void take(const Search& from, int i) {
    for (int r = 0; r < 3; ++r) x[r][n] = from.x[r][i], e[r][n] = from.e[r][i], f[r][n] = from.f[r][i];
    level[n++] = from.level[i];
  }
  void go_across(double way) {
    for (int i = 0; i < n; ++i)
      for (int r = 0; r < 3; ++r) x[r][i] += way * f[r][i];
  }
};

/// Result of a search for each point: distance to the edge, [m], and the slopes of the gap beyond it, along the search
/// and across. Without an edge all are 0.
struct Ways {
  Numbers way, along, across;
};

/// Searches for edges along a face that two solids share, of many points at once. Tests:
/// tests/contact/face_edges_test.cpp
class EdgeFinder {
 public:
  /// @param h  [m] step of the grid
  EdgeFinder(const CubeSide& a, const CubeSide& b, double h);
  /// d_a + d_b at x + t e, [m]. @param roughly  to a few hundredths of a voxel, some times as quick
  void gaps(const Search& s, const Numbers& t, Numbers& gap, bool roughly = false);
  void gaps(const Search& s, double t, Numbers& gap, bool roughly = false);
  /// Edges from x along sign e, to a few hundredths of a voxel; also where there is no face in the opposite direction.
  void glimpse(const Search& all, double sign, double reach, Ways& ways);
  /// Edges from x along sign e; none when there is none within reach, or no face in the opposite direction. Slopes
  /// across are not told.
  void find(const Search& all, double sign, double reach, Ways& ways);

 private:
  void distances(const CubeSide& side, const Search& s, const Numbers& t, bool roughly, Numbers& d);
  /// Takes the points whose gap rises within reach into near_, with that gap.
  void take_rising(const Search& all, double sign, double reach, bool roughly, Ways& ways);
  /// Change of the gap along a face that counts as zero, [m].
  double level_of(bool roughly) const;
  /// Drops points of near_.
  template <class Kept>
  void keep(const Kept& kept);
  /// Halves the ranges in which the gap begins to rise.
  void halve(double sign, int times, bool roughly);
  /// Drops points with a ridge on their way, which is no face.
  void drop_ridges(double sign);
  /// Gap at a distance, [voxels], beyond where it begins to rise.
  void beyond(double sign, double distance, Numbers& gap, bool roughly = false);
  /// The edge is where the line of the gap beyond it meets the level of the face. Points without one are dropped.
  void locate(double sign, double reach);
  void locate_exact(double sign);
  void locate_sampled(double sign, double reach);
  /// Slopes of the gap across the search, beyond the edge.
  void look_across(double sign);
  void put(Ways& ways) const;

  const CubeSide &a_, &b_;
  double h_;
  bool exact_;  ///< distances are exact, not sampled: they rise right at edges
  Search near_;
  std::array<int, kTogether> of_;
  Numbers rise_, lo_, hi_, way_, along_, across_{};  ///< of near_
  std::array<Numbers, 3> beyond_;
  Numbers gap_, other_, left_, right_, t_;
  Vectors local_;
};

}  // namespace brim
