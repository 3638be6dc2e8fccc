#pragma once

#include <memory>
#include <vector>

#include "brim/scene/solid.h"

namespace brim {

/// The solids that were sampled and that bodies still have: an equal surface in equal voxels is sampled once, however
/// many bodies say so. Tests: tests/scene/solid_store_test.cpp
class SolidStore {
 public:
  /// Sets shape and mass properties of a solid with samples at half of its voxel_size, from a surface of any form.
  /// @param memory_limit  [bytes] of the samples @throws InputError  for a surface that does not fit its treatment
  void sample(const SolidSurface& source, double memory_limit, Solid& solid);

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
