#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "brim/contact/contact_set.h"

namespace brim {

/// Prevents a kick at a change of level. The overlap that appears when two bodies are suddenly resolved finer or
/// coarser did not come about by motion: it is subtracted from the pair's depths and given back evenly within half a
/// second, so that they separate at no more than twice the jump per second. Penalties only: rows correct positions
/// without velocity.
class LevelShift {
 public:
  /// [s] over which a shift is given back.
  static constexpr double kSpan = 0.5;
  using Pair = std::pair<std::int32_t, std::int32_t>;

  /// The largest depth of a pair, [m], and the step at which it was found.
  struct Depth {
    double depth = 0.0, h = 0.0;
  };
  static std::map<Pair, Depth> depths(const ContactSet& contacts);
  /// A change of level. When a pair is resolved finer, it keeps its depth in voxels, so that its force is the same.
  /// @param before, after  depths as found by the search; existing shifts are subtracted here
  void change(const std::map<Pair, Depth>& before, const std::map<Pair, Depth>& after);
  /// Subtracts the shifts from depths; overlaps decrease in proportion, and are negative where depths are.
  void apply(ContactSet& contacts) const;
  /// Advances time, [s].
  void pass(double dt);

  bool empty() const { return shift_.empty(); }
  /// The whole state as numbers, and back.
  std::vector<double> numbers() const;
  void take(std::span<const double> numbers);

 private:
  struct Shift {
    double now = 0.0;   ///< [m]
    double rate = 0.0;  ///< [m/s]
  };
  std::map<Pair, Shift> shift_;
};

}  // namespace brim
