#include "brim/world/report_fields.h"

#include <algorithm>
#include <iterator>
#include <vector>

namespace brim {

namespace {

template <auto Member>
constexpr ReportField field(const char* name, const char* unit) {
  return {name, unit, [](const StepReport& r) { return static_cast<double>(r.*Member); },
          [](StepReport& r, double x) { r.*Member = static_cast<std::remove_reference_t<decltype(r.*Member)>>(x); }};
}

template <Phase P>
constexpr ReportField seconds(const char* name) {
  return {name, "s", [](const StepReport& r) { return r.seconds[static_cast<std::size_t>(P)]; },
          [](StepReport& r, double x) { r.seconds[static_cast<std::size_t>(P)] = x; }};
}

constexpr ReportField kFields[] = {
    field<&StepReport::dt>("dt", "s"),
    field<&StepReport::substeps>("substeps", ""),
    field<&StepReport::ok>("ok", ""),
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
    field<&StepReport::contacts>("contacts", ""),
    field<&StepReport::cg_iterations>("cg_iterations", ""),
    field<&StepReport::solves>("solves", ""),
    field<&StepReport::cg_residual>("cg_residual", ""),
    field<&StepReport::sweeps>("sweeps", ""),
    field<&StepReport::row_residual>("row_residual", ""),
    field<&StepReport::worst_overlap>("worst_overlap", "voxels"),
    field<&StepReport::kinetic_energy>("kinetic_energy", "J"),
    field<&StepReport::potential_energy>("potential_energy", "J"),
    field<&StepReport::contact_energy>("contact_energy", "J"),
    field<&StepReport::momentum_error>("momentum_error", ""),
    field<&StepReport::angular_error>("angular_error", ""),
    field<&StepReport::max_speed>("max_speed", "m/s"),
    field<&StepReport::stiffness>("stiffness", "Pa"),
};

}  // namespace

std::span<const ReportField> report_fields() { return kFields; }

void join(StepReport& frame, StepReport&& next) {
  frame.time = next.time;
  frame.dt += next.dt;
  frame.substeps += next.substeps;
  frame.ok = frame.ok && next.ok;
  for (std::size_t i = 0; i < frame.seconds.size(); ++i) frame.seconds[i] += next.seconds[i];
  frame.wall += next.wall;
  frame.tiles_present += next.tiles_present;
  frame.tiles += next.tiles;
  frame.voxels += next.voxels;
  frame.contacts = next.contacts;
  frame.cg_iterations += next.cg_iterations;
  frame.solves += next.solves;
  frame.sweeps += next.sweeps;
  frame.row_residual = std::max(frame.row_residual, next.row_residual);
  frame.cg_residual = std::max(frame.cg_residual, next.cg_residual);
  frame.worst_overlap = std::max(frame.worst_overlap, next.worst_overlap);
  frame.kinetic_energy = next.kinetic_energy;
  frame.potential_energy = next.potential_energy;
  frame.contact_energy = next.contact_energy;
  frame.momentum_error = std::max(frame.momentum_error, next.momentum_error);
  frame.angular_error = std::max(frame.angular_error, next.angular_error);
  frame.max_speed = next.max_speed;
  frame.stiffness = next.stiffness;
  frame.pairs = std::move(next.pairs);
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
