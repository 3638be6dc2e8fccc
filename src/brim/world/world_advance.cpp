// A sub-step after its solve: what is reported of it, and the motion of the bodies.
#include <algorithm>

#include "brim/body/keeps_energy.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/stopwatch.h"
#include "brim/world/momentum_check.h"
#include "brim/world/pair_reports.h"
#include "brim/world/rolling_resistance.h"
#include "brim/world/world_impl.h"

namespace brim {

void World::Impl::find_contact_forces() {
  const std::size_t n = stage.contacts().size();
  normal_force.resize(n), friction_force.resize(n), contact_force.resize(n);
  response.forces(implicit.contact_delta(), normal_force, friction_force);
  fill.add_forces(normal_force);
  for (std::size_t c = 0; c < n; ++c) contact_force[c] = normal_force[c] + friction_force[c];
}

void World::Impl::report_substep(double dt, bool last, StepReport& report) {
  const ScopedSeconds timer(report.seconds_of(Phase::Respond));
  const ContactSet& contacts = stage.contacts();
  find_contact_forces();
  report_pairs(parts, contacts, laws.penalties(), normal_force, friction_force, state.time, report, samples);
  stage.rigid().report(parts, state.time, report);
  // Before stiff contact has separated overlapping bodies.
  if (state.step == 0 && report.substeps == 1) warn_of_start(parts, state.time, report);
  std::vector<double> mapped(last && contacts.size() > 0 ? state.v.size() : 0, 0.0);
  if (last && contacts.size() > 0) {
    maps.add_forces(contact_force, mapped);
    check_momentum(bodies, first_v, parts, contacts, mapped, contact_force, report);
  }
  tell_walled(dt, mapped);
  links.remember(dt);
  if (!links.empty()) {
    links.finish(contacts, contact_force, state.time, report);
    keep_apart();
  }
  constraints.finish(report, samples, last, state.warm_start);
  if (!constraints.empty() && !constraints.converged()) warn_of_mass_ratio(parts, laws, options, state.time, report);
  resist_rolling(parts, first_v, report.pairs, laws, options, dt, state.v, delta);
  if (!coupling.empty()) {
    way_v = state.v;
    for (std::size_t i = 0; i < way_v.size(); ++i) way_v[i] += delta[i];
    coupling.report(dt, way_v, report, samples);
  }
  add_impulses(parts, bodies.size(), dt, report);
  report.contact_energy = response.energy();
  for (const auto& w : watchers) w->substep(*self, state.time, dt);
}

void World::Impl::advance(double dt, StepReport& report) {
  const ScopedSeconds timer(report.seconds_of(Phase::Advance));
  for (std::size_t i = 0; i < state.v.size(); ++i) state.v[i] += delta[i];
  way_v = state.v;
  for (std::size_t i = 0; i < constraints.position_correction().size(); ++i)
    way_v[i] += constraints.position_correction()[i];
  flight.find(bodies, parts, stage, filter, laws, actions, options);
  coupling.for_pairs([&](int fluid, int solid) {
    flight.hold(static_cast<std::size_t>(fluid)), flight.hold(static_cast<std::size_t>(solid));
  });
  parallel_for(bodies.size(), [&](std::size_t b) {
    if (sleep.asleep(b) || is_frozen(b)) return;
    const ProfileScope scope("advance", *bodies[b]);
    const auto own = [&](const std::vector<double>& x) { return std::span(x).subspan(first_v[b], v(b).size()); };
    bodies[b]->advance(dt, q(b), own(way_v));
    bodies[b]->finish_step(state.time, dt, q(b), v(b));
    if (flight.flies(b)) FreeFlight::set_back(*bodies[b], dt, own(delta), own(way_v), q(b), v(b));
    auto* kept = flight.is_free(b) ? interface_of<KeepsEnergy>(*bodies[b]) : nullptr;
    if (kept != nullptr) kept->keep_energy(state.time + dt, q(b), v(b));
  });
  stir();
  levels.shift().pass(dt);
  state.time += dt;
}

void World::Impl::follow_solids(StepReport& report) {
  if (coupling.empty()) return;
  const ScopedSeconds timer(report.seconds_of(Phase::Advance));
  // The masses of faces change as solids move; at the start of a step they must follow from the state alone.
  update_bodies();
  if (filter.size() > 0) filter.moved();
  coupling.find(bodies, parts, filter, state.q, first_v, state.v);
}

}  // namespace brim
