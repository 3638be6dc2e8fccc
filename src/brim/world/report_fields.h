#pragma once

#include <span>

#include "brim/world/step_report.h"

namespace brim {

/// How a scalar is combined when reports of several steps are accumulated.
enum class Joining {
  Sum,      ///< counts and times
  Largest,  ///< worst values
  Least,    ///< conditions that must hold in all
  Last      ///< states
};

/// One scalar of a step report, for files and tables that treat all scalars alike. A new scalar of StepReport needs one
/// line in the table of report_fields.cpp; files, tables and profiles then include it.
struct ReportField {
  const char* name;  ///< "worst_overlap", "seconds_solve", ...
  const char* unit;  ///< "voxels", "s", ...; "" for counts and ratios
  double (*get)(const StepReport&);
  void (*set)(StepReport&, double);
  Joining joining;
};

/// Every scalar of StepReport in a fixed order; the seconds of each phase are separate fields.
std::span<const ReportField> report_fields();

/// Adds the report of the next step to that of the steps before it, so that one report covers a whole frame: counts and
/// times are summed, worst values kept, states (energy, contacts, pairs) are those of the later step.
void accumulate(StepReport& frame, StepReport&& next);

/// [s] spent on contact: presence to respond, and its share of the solve.
double contact_seconds(const StepReport& report);

}  // namespace brim
