// A sub-step up to its solve: its length, contacts, responses, and the velocities that they give. What follows is in
// world_advance.cpp.
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "brim/core/error.h"
#include "brim/core/stop.h"
#include "brim/core/stopwatch.h"
#include "brim/world/ball_points.h"
#include "brim/world/fluid_warnings.h"
#include "brim/world/leapfrog.h"
#include "brim/world/reference_poses.h"
#include "brim/world/row_memory.h"
#include "brim/world/substeps.h"
#include "brim/world/world_impl.h"

namespace brim {

namespace {

/// Motion of a sub-step relative to the limit, above which it is solved again in pieces.
constexpr double kOutrun = 1.25;

/// [m/s²] gravity of the earth.
constexpr double kEarth = 9.81;
/// Slip up to which friction counts as sticking, relative to a free fall over a step; [m/s] at least.
constexpr double kStickingSlip = 1e-3, kLeastSlip = 1e-9;
/// Separation speed above which a node in tension is released, relative to a free fall over a sub-step.
constexpr double kReleased = 0.2;
/// Approach from which on rows bounce, relative to a free fall over a sub-step: what only rests does not.
constexpr double kBounces = 2.0;
/// [m/s] least velocity by which changes of the rows are judged, where there is no gravity.
constexpr double kLeastScale = 1e-6;

bool all_finite(std::span<const double> x) {
  return std::ranges::all_of(x, [](double value) { return std::isfinite(value); });
}

PenaltyOptions penalty_options(const WorldOptions& world, double dt) {
  const double g = world.environment.gravity.norm();
  // Without gravity, that of the earth: friction divided by a speed near zero would exceed single precision.
  const double sticking = std::max(kStickingSlip * (g > 0.0 ? g : kEarth) * world.time_step, kLeastSlip);
  PenaltyOptions o;
  o.dt = dt;
  o.damping = world.damping_steps * world.time_step;
  o.friction_speed = world.friction_speed > 0.0 ? world.friction_speed : sticking;
  o.release_speed = kReleased * g * dt;
  o.slack = g * dt * dt;
  return o;
}

ConstraintStep::Settings row_settings(const WorldOptions& world, double dt) {
  const double fall = world.environment.gravity.norm() * dt;
  ConstraintStep::Settings s;
  s.rows = {dt, kBounces * fall, world.constraint_every_node};
  s.tolerance = world.constraint_tolerance;
  s.max_sweeps = world.constraint_sweeps;
  s.scale = std::max(fall, kLeastScale);
  return s;
}

}  // namespace

void World::Impl::prescribe(double dt) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (is_frozen(b)) continue;
    bodies[b]->prescribe(state.time, dt, q(b), v(b));
    if (!sleep.asleep(b)) continue;
    if (std::any_of(v(b).begin(), v(b).end(), [](double x) { return x != 0.0; }) || driven(b, dt)) sleep.wake(b);
  }
  if (!sleep.on()) return;
  std::vector<int> pushed;
  actions.find_changing(state.time, dt, pushed);
  for (const int b : pushed) sleep.wake(static_cast<std::size_t>(b));
  sleep.mark(parts, state.v, first_v);
}

void World::Impl::find_contacts(double dt, StepReport& report) {
  do {
    stage.find(parts, state.v, first_v, dt, held_pairs, options, report);
    {
      const ScopedSeconds timer(report.seconds_of(Phase::Detect));
      if (filter.size() > 0) filter.moved(), filter.apply(parts, stage.contacts());
      levels.shift().apply(stage.contacts());
    }
    self_contact.find(parts, state.v, first_v, dt, options, report, stage.contacts());
    const ScopedSeconds timer(report.seconds_of(Phase::Detect));
    fill.find(bodies, parts, options, filter, stage.contacts());
  } while (sleep.on() && wake_touched());
}

void World::Impl::begin_substep(double dt, StepReport& report) {
  check_stop();
  prescribe(dt);
  {
    const ScopedSeconds timer(report.seconds_of(Phase::Advance));
    update_bodies();
  }
  if (filter.size() > 0) filter.moved();
  coupling.find(bodies, parts, filter, state.q, first_v, {});
  if (sleep.on()) wake_in_fluids();
  find_contacts(dt, report);
  tell_touched();
  check_stop();
  if (!links.empty())
    links.append(parts, {state.q, state.v, first_q, first_v}, static_cast<int>(parts.size()) - 1, state.time, dt,
                 options.time_step / options.min_substeps, stage.contacts());
}

void World::Impl::begin_penalties(double dt, StepReport& report) {
  ContactSet& contacts = stage.contacts();
  velocity_a.resize(contacts.size()), velocity_b.resize(contacts.size());
  const ScopedSeconds timer(report.seconds_of(Phase::Respond));
  laws.choose(parts, state.v, first_v, options, stage);
  laws.leave_to_links(parts, contacts, contacts.first_link_pair());
  response.find_normals(contacts, laws.penalties());
  place_under_balls(parts, response.normals(), contacts);
  maps.build(parts, contacts, first_v);
  maps.for_directed([&](std::size_t c, const Vec3& n) { response.set_normal(c, n); });
  maps.velocities(state.v, velocity_a, velocity_b);
  turning.begin(parts, contacts, state.v, first_v, dt);
  if (turning.any()) turning.add_slips(contacts, response.normals(), velocity_a, velocity_b);
  response.begin(contacts, laws.penalties(), penalty_options(options, dt), velocity_a, velocity_b);
  fill.begin(bodies, first_v, state.v, velocity_a, velocity_b, dt, response);
  if (contacts.link_pairs > 0)
    links.begin(parts, {state.q, state.v, first_q, first_v}, contacts, velocity_a, velocity_b, response);
}

void World::Impl::begin_rows(double dt, StepReport& report) {
  const ScopedSeconds timer(report.seconds_of(Phase::Respond));
  constraints.begin(bodies, first_v, parts, stage.contacts(), response.normals(), laws.constraints(),
                    stage.rigid().gather(), state.v, row_settings(options, dt),
                    ReferencePoses::rows_of(state.warm_start));
}

bool World::Impl::solve_system(double dt, StepReport& report) {
  ImplicitStep::Settings settings;
  settings.dt = dt;
  settings.tolerance = options.cg_tolerance;
  settings.max_iterations = options.cg_max_iterations;
  settings.passes = options.max_passes;
  std::vector<std::uint8_t> unmoved(sleep.on() || !edits.frozen.empty() ? bodies.size() : 0);
  for (std::size_t b = 0; b < unmoved.size(); ++b) unmoved[b] = sleep.asleep(b) || is_frozen(b);
  settings.unmoved = unmoved;
  delta.resize(state.v.size());
  std::span<const double> impulse = constraints.impulse();
  std::span<const std::vector<Mat3>> resistance;
  if (!actions.empty()) {
    impulse = actions.impulse(bodies, parts, state.q, first_q, state.v, first_v, state.time, dt, impulse);
    resistance = actions.resistance();
    settings.gravity_scale = actions.gravity_scale();
  }
  if (stage.contacts().link_pairs > 0) {
    leapfrog_gravity(parts, stage, bodies.size(), links.last_substep(), dt, settings.gravity_scale, gravity_factor);
    settings.gravity_scale = gravity_factor;
  }
  ImplicitStep::Correct rows;
  if (!constraints.empty())
    rows = [&](const ImplicitStep::Respond& solve, std::span<double> change, std::span<double> added) {
      return constraints.correct(solve, change, added, report);
    };
  StepContext context{bodies,   first_v, parts,   options.environment, state.v, stage.contacts(), maps, response, fill,
                      coupling, report,  impulse, resistance};
  if (links.bends() && stage.contacts().link_pairs > 0)
    context.follow_arcs = [&](std::span<const double> change, std::span<const Vec3> at_contacts) {
      predicted_v = state.v;
      for (std::size_t i = 0; i < predicted_v.size(); ++i) predicted_v[i] += change[i];
      return links.follow_arcs(parts, {state.q, predicted_v, first_q, first_v}, stage.contacts(), at_contacts,
                               response);
    };
  return implicit.solve(context, settings, delta, rows);
}

bool World::Impl::solve_substep(double dt, StepReport& report) {
  begin_substep(dt, report);
  begin_penalties(dt, report);
  begin_rows(dt, report);
  tell_loads(dt);
  // An infinite force on a body that touches nothing does not reach the scalars of the solve.
  if (!solve_system(dt, report) || !all_finite(delta)) return false;
  find_swing(report);
  return true;
}

double World::Impl::motion_pieces(std::span<const double> velocities, double time, double change) {
  return std::max(brim::motion_pieces(parts, velocities, first_v, options, time, change, held_pairs, motion_sweep),
                  self_contact.motion_pieces(parts, velocities, first_v, options, time, change, motion_sweep));
}

double World::Impl::choose_length(double left, StepReport& report) {
  const ScopedSeconds timer(report.seconds_of(Phase::Presence));
  const double g = options.environment.gravity.norm();
  held_pairs = state.step == 0 && report.substeps == 0
                   ? HeldPairs()
                   : HeldPairs(RowMemory::pairs(ReferencePoses::rows_of(state.warm_start)));
  const NeededPieces needed = {motion_pieces(state.v, left, g * left), fall_pieces(parts, g, left),
                               stable_pieces(parts, left), links.swing_pieces(left),
                               links.spin_pieces(parts, state.v, first_v, left)};
  return choose_substep(needed, parts, state.v, first_v, options, left, report);
}

double World::Impl::pieces_after_solve(double dt, StepReport& report) {
  predicted_v = state.v;
  for (std::size_t i = 0; i < predicted_v.size(); ++i) predicted_v[i] += delta[i];
  const ScopedSeconds timer(report.seconds_of(Phase::Presence));
  return std::max(motion_pieces(predicted_v, dt, 0.0),
                  thrown_pieces(parts, delta, first_v, options, dt, held_pairs, motion_sweep));
}

void World::Impl::find_swing(StepReport& report) {
  if (stage.contacts().link_pairs == 0) return;
  const ScopedSeconds timer(report.seconds_of(Phase::Respond));
  find_contact_forces();
  links.find_swing(parts, stage.contacts(), contact_force);
}

void World::Impl::take_back() {
  state.q = before_q;
  state.v = before_v;
  links.drop_swing();
  fresh.clear();
}

double World::Impl::solve_within_limits(double dt, StepReport& report) {
  before_q = state.q;
  before_v = state.v;
  const std::size_t warnings = report.warnings.size();
  report.ok = solve_substep(dt, report);
  // Contact may throw a body faster than predicted from the speeds before: cut again, once.
  if (!report.ok || report.substeps + 1 >= options.max_substeps) return dt;
  const double needed = std::max(pieces_after_solve(dt, report), links.swing_pieces(dt));
  if (!(needed > kOutrun)) return dt;
  take_back();
  report.warnings.erase(report.warnings.begin() + static_cast<std::ptrdiff_t>(warnings), report.warnings.end());
  dt /= std::ceil(needed);
  report.ok = solve_substep(dt, report);
  return dt;
}

std::string World::Impl::blame_for_nan() const {
  const auto bad = [](std::span<const double> x) { return !all_finite(x); };
  std::vector<double> forces;
  const auto of = [&](const std::vector<double>& all, std::size_t b) {
    const std::span<const double> x = all;
    return x.size() < first_v.back() ? std::span<const double>() : x.subspan(first_v[b], first_v[b + 1] - first_v[b]);
  };
  const auto first = [&](const char* what, const auto& is_bad) -> std::string {
    for (std::size_t b = 0; b < count(); ++b)
      if (!out(b) && is_bad(b)) return fmt::format("; the first are {} of '{}'", what, bodies[b]->name());
    return "";
  };
  // What a body brings is bad for it alone; the solve spreads it to all.
  std::string found = first("coordinates", [&](std::size_t b) { return bad(kept_q(b)); });
  if (found.empty()) found = first("velocities", [&](std::size_t b) { return bad(kept_v(b)); });
  if (found.empty())
    found = first("forces", [&](std::size_t b) {
      forces.assign(bodies[b]->v_size(), 0.0);
      bodies[b]->add_forces(options.environment, forces);
      return bad(forces);
    });
  if (found.empty()) found = first("changes of velocity", [&](std::size_t b) { return bad(of(delta, b)); });
  return found;
}

double World::Impl::substep(double left, StepReport& report) {
  const double dt = solve_within_limits(choose_length(left, report), report);
  ++report.substeps;
  report.contacts = static_cast<std::int64_t>(stage.contacts().first_link()) + stage.rigid().contacts();
  if (!report.ok) {
    const std::string blame = blame_for_nan();  // before the state is set back
    take_back();
    report.warnings.push_back(
        {state.time, "not_finite",
         fmt::format("the solve gave values that are not finite{}; the state before it is kept", blame)});
    return left;
  }
  if (const auto runaway = runaway_fluid(parts, state.v, first_v)) {
    take_back();
    report.ok = false;
    report.warnings.push_back({state.time, "runaway_fluid", *runaway});
    return left;
  }
  if (!std::exchange(fluids_told, true))
    if (const auto meeting = meeting_fluids(parts)) report.warnings.push_back({state.time, "two_fluids", *meeting});
  const bool last = left - dt <= 1e-9 * options.time_step;
  report_substep(dt, last, report);
  advance(dt, report);
  follow_solids(report);
  return dt;
}

}  // namespace brim
