#pragma once

#include "brim/raster/known_distance.h"

namespace brim {

/// Optional interface of shapes with edges or detail: the same solid as one that is seen in coarse voxels.
class AveragedDistances {
 public:
  virtual ~AveragedDistances() = default;
  /// The solid whose density is the share of matter in a ball of diameter w about each point, told as the distance that
  /// has this density under a ramp of that width (BallField): at flat surfaces the same, where the surface turns within
  /// a ramp its mean. Made the first time that a width is asked for. @param w  [m]
  virtual const KnownDistance& averaged(double w) const = 0;
  /// True where the shape may have detail that coarse voxels miss.
  virtual bool detailed() const = 0;
};

}  // namespace brim
