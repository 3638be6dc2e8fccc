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
  /// Of the metric "sensor": which reading, how it is taken over the window, and another that it is divided by.
  struct Reading {
    std::string sensor, channel;
  };
  Reading reading{}, over{};  ///< over: none where it names no sensor
  std::string take{};         ///< "mean", "sum" (of the frames after the first), "last", "least" or "largest"
  std::string known_miss{};   ///< figure and cause of a bound that is not met as yet; empty: it must hold
  double known_worst = std::numeric_limits<double>::quiet_NaN();  ///< how far a known miss may go; NaN: anywhere
};

}  // namespace brim
