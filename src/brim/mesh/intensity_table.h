#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace brim {

/// A material quantity as a function of intensity: linear between the points, constant outside.
struct IntensityTable {
  std::vector<std::pair<double, double>> points;  ///< (intensity, quantity), by ascending intensity; at least one

  double at(double intensity) const {
    const auto next = std::upper_bound(points.begin(), points.end(), intensity,
                                       [](double x, const auto& point) { return x < point.first; });
    if (next == points.begin()) return next->second;
    if (next == points.end()) return points.back().second;
    const auto& [x0, y0] = *(next - 1);
    const auto& [x1, y1] = *next;
    return y0 + (y1 - y0) * (intensity - x0) / (x1 - x0);
  }
};

}  // namespace brim
