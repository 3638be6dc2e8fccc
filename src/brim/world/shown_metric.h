#pragma once

#include <string>
#include <vector>

#include "brim/world/display_measures.h"
#include "brim/world/expectation.h"
#include "brim/world/number_fold.h"
#include "brim/world/world.h"

namespace brim {

/// A metric of one body's display, for some metrics relative to another body (`of`), computed frame by frame:
///   leak         vertices with the sheet `of` above and not below them, the maximum over the window
///   draft        [m] surface of the fluid `of` around the body minus its lowest point, mean over the window
///   level        [m] height of the upper surface (surface_level), mean over the window
///   volume_kept  volume inside the surface over that at the start of the run; the value of the window farthest from 1
///   front        [m] largest x of the vertices, at the end of the window
/// Tests: tests/world/measures_test.cpp
class ShownMetric {
 public:
  static const std::vector<std::string>& names();
  static bool knows(const std::string& metric);
  /// True for metrics that need `of`.
  static bool needs_other(const std::string& metric);

  /// @throws InputError  when a named body does not exist
  ShownMetric(const World& world, const Expectation& expectation);

  /// The value in the world's present state.
  double now(const World& world) const;
  /// How the values of a window's frames are combined.
  NumberFold::Take take() const;

 private:
  std::string metric_;
  int body_ = -1, other_ = -1;
  double width_ = 0.0;         ///< [m] of the columns of a fluid's surface
  double volume_start_ = 0.0;  ///< [m³]
};

}  // namespace brim
