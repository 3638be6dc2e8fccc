#pragma once

#include <limits>
#include <string>

namespace brim {

/// A number that a run must keep within bounds. The metrics are listed with the Measures that find them.
struct Expectation {
  std::string metric;
  std::string
      body;  ///< a body, or the stem of numbered copies ("box" for box.0, box.1, ...); empty: all movable bodies
  std::string of{};                                       ///< another body, for metrics that say so
  double from = 0.0;                                      ///< [s] start of the window
  double to = std::numeric_limits<double>::infinity();    ///< [s] end of the window
  double min = -std::numeric_limits<double>::infinity();  ///< least allowed
  double max = std::numeric_limits<double>::infinity();   ///< most allowed
  std::string known_miss{};  ///< figure and cause of a bound that is not met as yet; empty: it must hold
};

}  // namespace brim
