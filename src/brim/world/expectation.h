#pragma once

#include <limits>
#include <string>

namespace brim {

/// A number that a run must keep within bounds. Measures lists the metrics.
struct Expectation {
  std::string metric;
  std::string
      body;  ///< a body, or the stem of numbered copies ("box" for box.0, box.1, ...); empty: all movable bodies
  std::string of{};                                       ///< another body, for metrics that say so
  double from = 0.0;                                      ///< [s] start of the window
  double to = std::numeric_limits<double>::infinity();    ///< [s] end of the window
  double min = -std::numeric_limits<double>::infinity();  ///< smallest allowed value
  double max = std::numeric_limits<double>::infinity();   ///< largest allowed value
  /// For the metric "sensor": the reading, its statistic over the window, and optionally a reading to divide by.
  struct Reading {
    std::string sensor, channel;
  };
  Reading reading{}, over{};  ///< over: none when its sensor is empty
  std::string take{};         ///< "mean", "sum" (of the frames after the first), "last", "least" or "largest"
  std::string known_miss{};   ///< value and cause of a bound that is not met yet; empty: the bound must hold
  double known_worst = std::numeric_limits<double>::quiet_NaN();  ///< worst allowed value of a known miss; NaN: any
};

}  // namespace brim
