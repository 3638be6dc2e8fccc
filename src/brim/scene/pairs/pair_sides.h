#pragma once

#include <span>
#include <vector>

#include "brim/body/body.h"

namespace brim {

/// Measures how much of two bodies has passed through each other along z, from their display geometry.
///
/// Both are divided into vertical columns of a given width. In a column with points of both, the bodies have leaked if
/// all points of the upper one are below all of the lower one; a body of loose points (grains, particles) is judged
/// point by point, with a tolerance of one width. Bodies may flow and hang around each other's edges: a sheet wrapped
/// around a bar has not leaked.
class PairSides {
 public:
  /// @param width  [m] of the columns, > 0
  explicit PairSides(double width) : width_(width) {}

  /// @return fraction of leaked points, of the worse body, [0, 1]
  double leaked(const Body& lower, const Body& upper);
  /// @return fraction of a body's points more than a width below the height z [m], [0, 1]
  double below(const Body& body, double z);

 private:
  void sample(const Body& body, std::vector<Vec3f>& points);

  double width_;
  std::vector<Vec3f> corners_, lower_, upper_;
};

}  // namespace brim
