#pragma once

#include <string>
#include <vector>

#include "brim/world/step_report.h"

namespace brim::cli {

/// Where the time of a run goes, as `brim run --profile` prints it: phases of a step, phases by kind of body, counters.
class ProfileTable {
 public:
  ProfileTable();
  /// @param frame  report of a frame  @param steps  that it joins
  void add(const StepReport& frame, int steps);
  /// @param threads  that the run could use
  std::string text(int threads) const;

 private:
  std::string phases(double wall) const;
  static std::string kinds();
  std::string counters() const;

  std::vector<double> total_;  ///< of each of report_fields(), joined over the run
  double contact_ = 0.0;       ///< [s]
  double steps_ = 0.0;
};

}  // namespace brim::cli
