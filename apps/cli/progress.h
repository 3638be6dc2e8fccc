#pragma once

#include <string>

#include "brim/record/runner.h"

namespace brim::cli {

/// Shows a run as it goes: a bar on a terminal, JSON lines for programs, nothing otherwise.
class Progress {
 public:
  enum class Style { Bar, Json, Quiet };
  /// @param endless  the run goes on until it is ended: no share of it is done
  explicit Progress(Style style, bool endless = false) : style_(style), endless_(endless) {}
  void start(const std::string& scene, const std::string& folder, const RunPlan& plan, const World& world);
  void frame(const RunProgress& progress);
  void end(const RunResult& result, const std::string& folder);

 private:
  Style style_;
  bool endless_;
  double last_shown_ = -1.0;
};

/// Each expectation, its value and its bounds, one a line: "ok", "miss" (and known), "open" (the run ends before it) or
/// "FAIL". Under a check only what is as expected does not fail, as its exit says.
std::string findings_table(const std::vector<ExpectationResult>& findings, bool check);

}  // namespace brim::cli
