#pragma once

#include <span>

namespace brim {

/// Optional interface of bodies whose forces or shape may change with time while their coordinates stay: own bodies
/// that read the time. Such a change wakes them when they sleep, and keeps them awake (WorldOptions::sleep). Tests:
/// tests/world/sleep_test.cpp
class TimeDriven {
 public:
  virtual ~TimeDriven() = default;
  /// True when forces or shape of the body at rest at q differ between two times, [s]. Afterwards the body is updated
  /// to the later one; to the earlier one it is updated only if its last update was another.
  /// @param q  coordinates, shape (nq)
  virtual bool changes(double from, double to, std::span<const double> q) = 0;
};

}  // namespace brim
