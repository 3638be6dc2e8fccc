#pragma once

#include <memory>
#include <vector>

#include "brim/scene/solid.h"

namespace brim {

/// Solids of surfaces in use by bodies: an equal surface with equal voxels is made a solid only once, for any number of
/// bodies.
/// Tests: tests/scene/solid_store_test.cpp
class SolidStore {
 public:
  /// Sets shape and mass properties of a solid: exact distances to a convex polyhedron of few faces (ConvexPolyhedron),
  /// and samples at half of its voxel_size for any other surface.
  /// @param memory_limit  [bytes] of the samples @throws InputError  for a surface that does not suit its treatment
  void make(const SolidSurface& source, double memory_limit, Solid& solid);

 private:
  struct Entry {
    SolidSurface source;
    double voxel_size;
    MassProperties unit;
    std::weak_ptr<const Shape> shape;
  };
  std::vector<Entry> entries_;
};

}  // namespace brim
