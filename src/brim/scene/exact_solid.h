#pragma once

#include <memory>
#include <optional>

#include "brim/mesh/mass_properties.h"
#include "brim/raster/shape.h"
#include "brim/scene/node.h"

namespace brim {

/// A shape with a formula for its distance, and what follows from formulas for its matter of 1 kg/m³.
struct ExactSolid {
  std::shared_ptr<const Shape> shape;
  MassProperties unit = {};  ///< mass 0: that of the surface's mesh is exact, or there is none
  double area = 0.0;         ///< [m²], 0: that of the surface's mesh is exact
};

/// Nothing for kinds of shape that have no formula.
/// @param n  a checked "shape"  @param scale  factor of all its lengths
/// Tests: tests/scene/exact_solid_test.cpp
std::optional<ExactSolid> exact_solid(const Node& n, double scale);

}  // namespace brim
