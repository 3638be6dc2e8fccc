#pragma once

#include <span>

#include "brim/world/step_report.h"

namespace brim {

/// What becomes of a scalar when the reports of several steps are joined.
enum class Joining {
  Sum,      ///< counts and times
  Largest,  ///< worst values
  Least,    ///< what must hold in all
  Last      ///< states
};

/// One scalar of a step report, for files and tables that treat all alike. Adding one to StepReport takes a line in the
/// table of report_fields.cpp; files, tables and profiles then have it.
struct ReportField {
  const char* name;  ///< "worst_overlap", "seconds_solve", ...
  const char* unit;  ///< "voxels", "s", ...; "" for counts and ratios
  double (*get)(const StepReport&);
  void (*set)(StepReport&, double);
  Joining joining;
};

/// Every scalar of StepReport, in a fixed order; each phase's seconds are fields of their own.
std::span<const ReportField> report_fields();

/// Joins the report of the next step to that of the steps before it, so that one report speaks of a whole frame:
/// counts and times add up, worst values stay, states (energy, contacts, pairs) are those of the later step.
void accumulate(StepReport& frame, StepReport&& next);

/// Seconds that contact took: presence to respond, and its share of the solve.
double contact_seconds(const StepReport& report);

}  // namespace brim
