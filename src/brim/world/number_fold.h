#pragma once

#include <cstdint>

namespace brim {

/// One statistic of a sequence of numbers, in constant memory. NaN propagates: any NaN makes the result NaN, except for
/// Last.
/// Tests: tests/world/number_fold_test.cpp
class NumberFold {
 public:
  enum class Take {
    Mean,
    Sum,
    SumAfterFirst,  ///< of numbers about the time before them: the first belongs to the time before the window
    Last,
    Least,
    Largest,
    FarthestFromOne,
  };
  explicit NumberFold(Take take) : take_(take) {}

  void add(double x);
  /// NaN before the first number.
  double value() const;

 private:
  Take take_;
  std::int64_t count_ = 0;
  double value_ = 0.0;
};

}  // namespace brim
