#pragma once

#include <span>
#include <vector>

#include "brim/body/body.h"

namespace brim {

/// Tells how much of two bodies has come to the wrong side of each other along z, from what they show of themselves.
///
/// Both are cut into columns of a given width. Where a column holds points of both and all of the upper body's are
/// below all of the lower's, they have leaked; a body of loose points (grains, particles) is judged point by point, by
/// more than a width. Around each other's edges bodies may flow and hang: a sheet wrapped around a bar has not leaked.
class PairSides {
 public:
  /// @param width  [m] of the columns, > 0
  explicit PairSides(double width) : width_(width) {}

  /// @return share of points that have leaked, of the body that does worse, [0, 1]
  double leaked(const Body& lower, const Body& upper);
  /// @return share of a body's points more than a width below the height z [m], [0, 1]
  double below(const Body& body, double z);

 private:
  void sample(const Body& body, std::vector<Vec3f>& points);

  double width_;
  std::vector<Vec3f> corners_, lower_, upper_;
};

}  // namespace brim
