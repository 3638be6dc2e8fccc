#pragma once

namespace brim {

/// Optional interface of bodies with explicit inner forces that are stable up to a step only: sub-steps are no longer.
/// Tests: tests/world/substeps_test.cpp
class LongestStep {
 public:
  virtual ~LongestStep() = default;
  virtual double longest_step() const = 0;  ///< [s] infinite where none is too long
};

}  // namespace brim
