#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "brim/contact/contact_set.h"

namespace brim {

/// Keeps a change of level from kicking. What two bodies seem to overlap by when they are suddenly seen finer or
/// coarser is no overlap that came about by motion: it is taken off the pair's depths, and given back evenly within
/// half a second, so that they part at no more than twice the jump a second. Penalties only: rows correct places
/// without velocity.
class LevelShift {
 public:
  /// [s] in which a shift is given back.
  static constexpr double kSpan = 0.5;
  using Pair = std::pair<std::int32_t, std::int32_t>;

  /// The largest depth of a pair, [m], and the step at which it was found.
  struct Depth {
    double depth = 0.0, h = 0.0;
  };
  static std::map<Pair, Depth> depths(const ContactSet& contacts);
  /// A change of level. Of the depth that a pair had it keeps, where it is seen finer now, as many voxels: the force is
  /// then the same. @param before, after  depths as the search finds them; what is already shifted is taken off
  void change(const std::map<Pair, Depth>& before, const std::map<Pair, Depth>& after);
  /// Takes the shifts off depths; overlaps become less in the same measure, and are below zero where depths are.
  void apply(ContactSet& contacts) const;
  /// Time goes by, [s].
  void pass(double dt);

  bool empty() const { return shift_.empty(); }
  /// All of it as numbers, and back.
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
