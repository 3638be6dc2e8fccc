#pragma once

#include <cstdint>

namespace brim {

/// One number of many that come one after another and are not kept. Not-a-number never hides behind a comparison: of
/// all but Last it makes the result not-a-number.
/// Tests: tests/world/number_fold_test.cpp
class NumberFold {
 public:
  enum class Take {
    Mean,
    Sum,
    SumAfterFirst,  ///< of numbers that speak of the time before them: the first belongs to what came before
    Last,
    Least,
    Largest,
    FarthestFromOne,
  };
  explicit NumberFold(Take take) : take_(take) {}

  void add(double x);
  /// Not-a-number before the first number.
  double value() const;

 private:
  Take take_;
  std::int64_t count_ = 0;
  double value_ = 0.0;
};

}  // namespace brim
