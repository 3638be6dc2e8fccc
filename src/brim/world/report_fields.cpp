#include "brim/world/report_fields.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <type_traits>
#include <vector>

namespace brim {

namespace {

/// Converts a recorded number to a report's. Integers are clamped to their type's range, whatever a file contains.
template <class T>
T as(double x) {
  if constexpr (std::is_same_v<T, bool>) return x != 0.0;
  if constexpr (!std::is_integral_v<T>) return static_cast<T>(x);
  constexpr double kMost = std::min(static_cast<double>(std::numeric_limits<T>::max()), 9e15);
  return x >= -kMost && x <= kMost ? static_cast<T>(x) : T{};
}

template <auto Member, Joining J = Joining::Sum>
constexpr ReportField field(const char* name, const char* unit) {
  return {name, unit, [](const StepReport& r) { return static_cast<double>(r.*Member); },
          [](StepReport& r, double x) { r.*Member = as<std::remove_reference_t<decltype(r.*Member)>>(x); }, J};
}

template <Phase P>
constexpr ReportField seconds(const char* name) {
  return {name, "s", [](const StepReport& r) { return r.seconds[static_cast<std::size_t>(P)]; },
          [](StepReport& r, double x) { r.seconds[static_cast<std::size_t>(P)] = x; }, Joining::Sum};
}

constexpr ReportField kFields[] = {
    field<&StepReport::dt>("dt", "s"),
    field<&StepReport::substeps>("substeps", ""),
    field<&StepReport::ok, Joining::Least>("ok", ""),
    seconds<Phase::Presence>("seconds_presence"),
    seconds<Phase::Refine>("seconds_refine"),
    seconds<Phase::Rasterize>("seconds_rasterize"),
    seconds<Phase::Detect>("seconds_detect"),
    seconds<Phase::Respond>("seconds_respond"),
    seconds<Phase::Solve>("seconds_solve"),
    seconds<Phase::SolveContact>("seconds_solve_contact"),
    seconds<Phase::Advance>("seconds_advance"),
    seconds<Phase::Record>("seconds_record"),
    field<&StepReport::wall>("wall", "s"),
    field<&StepReport::tiles_present>("tiles_present", ""),
    field<&StepReport::tiles>("tiles", ""),
    field<&StepReport::voxels>("voxels", ""),
    field<&StepReport::contacts, Joining::Last>("contacts", ""),
    field<&StepReport::cg_iterations>("cg_iterations", ""),
    field<&StepReport::solves>("solves", ""),
    field<&StepReport::cg_residual, Joining::Largest>("cg_residual", ""),
    field<&StepReport::sweeps>("sweeps", ""),
    field<&StepReport::row_residual, Joining::Largest>("row_residual", ""),
    field<&StepReport::worst_overlap, Joining::Largest>("worst_overlap", "voxels"),
    field<&StepReport::kinetic_energy, Joining::Last>("kinetic_energy", "J"),
    field<&StepReport::potential_energy, Joining::Last>("potential_energy", "J"),
    field<&StepReport::contact_energy, Joining::Last>("contact_energy", "J"),
    field<&StepReport::momentum_error, Joining::Largest>("momentum_error", ""),
    field<&StepReport::angular_error, Joining::Largest>("angular_error", ""),
    field<&StepReport::max_speed, Joining::Last>("max_speed", "m/s"),
    field<&StepReport::asleep, Joining::Last>("asleep", ""),
    field<&StepReport::stiffness, Joining::Last>("stiffness", "Pa"),
};

}  // namespace

std::span<const ReportField> report_fields() { return kFields; }

void accumulate(StepReport& frame, StepReport&& next) {
  frame.time = next.time;
  for (const ReportField& f : kFields) {
    const double x = f.get(frame), y = f.get(next);
    switch (f.joining) {
      case Joining::Sum:
        f.set(frame, x + y);
        break;
      case Joining::Largest:
        f.set(frame, std::max(x, y));
        break;
      case Joining::Least:
        f.set(frame, std::min(x, y));
        break;
      case Joining::Last:
        f.set(frame, y);
        break;
    }
  }
  frame.impulse.resize(std::max(frame.impulse.size(), next.impulse.size()), Vec3::Zero());
  for (std::size_t b = 0; b < next.impulse.size(); ++b) frame.impulse[b] += next.impulse[b];
  frame.pairs = std::move(next.pairs);
  frame.links = std::move(next.links);
  std::move(next.warnings.begin(), next.warnings.end(), std::back_inserter(frame.warnings));
}

double contact_seconds(const StepReport& r) {
  double sum = 0.0;
  for (const Phase p :
       {Phase::Presence, Phase::Refine, Phase::Rasterize, Phase::Detect, Phase::Respond, Phase::SolveContact})
    sum += r.seconds[static_cast<std::size_t>(p)];
  return sum;
}

}  // namespace brim
