#pragma once

#include "brim/raster/known_distance.h"

namespace brim {

/// Optional interface of shapes with edges or detail: the solid as resolved by coarse voxels.
class AveragedDistances {
 public:
  virtual ~AveragedDistances() = default;
  /// The solid whose density is the volume fraction of a ball of diameter w about each point, expressed as the distance
  /// with this density under a ramp of that width (BallField): unchanged at flat surfaces, averaged where the surface
  /// turns within a ramp. Built on the first request for a width. @param w  [m]
  virtual const KnownDistance& averaged(double w) const = 0;
  /// True when the shape may have detail that coarse voxels miss.
  virtual bool detailed() const = 0;
};

}  // namespace brim
