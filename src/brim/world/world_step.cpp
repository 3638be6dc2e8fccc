#include <algorithm>
#include <cmath>
#include <cstring>

#include "brim/body/time_driven.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/stopwatch.h"
#include "brim/world/world_impl.h"

namespace brim {

void World::Impl::start() {
  const bool first = !started, changed = edited;
  if (!first && !changed) return;
  if (first) filter.meet(std::span(bodies).first(count()));  // may throw: then nothing has begun
  started = true, edited = false;
  if (changed) leave_out();
  if (first) choose_steps();
  follow_edits();
  if (first && options.sleep) sleep.start(bodies);
  take_memory();  // what is behind it is of the rows
  stage.rigid().restore(state.warm_start);
  keep_memory();
  if (changed) update_bodies();
}

void World::Impl::choose_steps() {
  double h0 = options.voxel_size;
  if (h0 == 0.0) {
    for (const WorldPart& p : parts)
      if (p.info.voxel_size > 0.0 && (h0 == 0.0 || p.info.voxel_size < h0)) h0 = p.info.voxel_size;
    if (h0 == 0.0) h0 = 0.05;
  }
  part_h.clear();
  for (WorldPart& p : parts) {
    const double own_size = own(static_cast<std::size_t>(p.body_index)).part(p.index).voxel_size;
    const double wanted = own_size > 0.0 ? own_size : h0;
    const int level = std::max(0, static_cast<int>(std::floor(std::log2(wanted / h0) + 1e-9)));
    part_h.push_back(std::ldexp(h0, level));
    p.h = part_h.back();
  }
  laws.start(parts, state.v, first_v, given, h0);
}

void World::Impl::stir() {
  for (std::size_t b = 0; b < fresh.size(); ++b) fresh[b] &= sleep.asleep(b);
}

bool World::Impl::driven(std::size_t b, double dt) {
  auto* body = dynamic_cast<TimeDriven*>(bodies[b].get());
  if (body == nullptr || is_frozen(b)) return false;
  const bool changes = body->changes(state.time, state.time + dt, q(b));
  // Awake, it goes on from now; asleep, it is the same at both times.
  if (changes || !sleep.asleep(b)) bodies[b]->update(state.time, q(b), v(b));
  return changes;
}

void World::Impl::update_bodies() {
  if (updated_q.size() != state.q.size() || updated_v.size() != state.v.size()) fresh.clear();
  if (updated_time != state.time) stir();
  updated_q.resize(state.q.size()), updated_v.resize(state.v.size()), fresh.resize(bodies.size(), 0);
  updated_time = state.time;
  // A step begins at the state that was measured last: unchanged bodies are not updated again.
  const auto taken = [](std::span<const double> from, std::span<double> to) {
    if (from.empty() || std::memcmp(from.data(), to.data(), from.size_bytes()) == 0) return false;
    std::copy(from.begin(), from.end(), to.begin());
    return true;
  };
  parallel_for(bodies.size(), [&](std::size_t b) {
    const bool new_q = taken(q(b), std::span(updated_q).subspan(first_q[b], q(b).size()));
    const bool new_v = taken(v(b), std::span(updated_v).subspan(first_v[b], v(b).size()));
    if (fresh[b] && !new_q && !new_v) return;
    const ProfileScope scope("update", *bodies[b]);
    bodies[b]->update(state.time, q(b), v(b));
    fresh[b] = 1;
  });
}

StepReport World::step() {
  Impl& w = *impl_;
  StepReport report;
  report.dt = w.options.time_step;
  report.time = w.state.time;
  {
    const ScopedSeconds timer(report.wall);
    const double loops = loop_seconds();
    w.run_scheduled(*this, report);
    w.start();
    report.stiffness = w.stiffness();
    if (w.state.step == 0) w.laws.warn(w.parts, w.options, report);
    w.take_memory();
    if (w.levels.on()) w.choose_levels(report);
    if (w.sleep.on()) {
      w.sleep.mark(w.parts, w.state.v, w.first_v);
    }
    for (const auto& watcher : w.watchers) watcher->begin_step(*this);
    double left = w.options.time_step;
    const double end = w.state.time + left;
    while (report.ok && left > 1e-9 * w.options.time_step) left -= w.substep(left, report);
    w.state.time = end;
    ++w.state.step;
    w.measure(report);
    profile_count(kSecondsInLoops.data(), loop_seconds() - loops);
  }
  report.time = w.state.time;
  for (const auto& watcher : w.watchers) watcher->end_step(*this, report);
  if (w.levels.on()) w.levels.took(report.wall);
  return report;
}

std::vector<Warning> World::material_warnings() {
  StepReport report;
  report.time = impl_->state.time;
  impl_->start();
  impl_->laws.warn(impl_->parts, impl_->options, report);
  return report.warnings;
}

StepReport World::present() {
  StepReport report;
  report.time = impl_->state.time;
  impl_->catch_up();
  impl_->update_bodies();
  impl_->measure_motion(report);
  return report;
}

void World::Impl::choose_levels(StepReport& report) {
  update_bodies();
  if (!levels.choose(state.step, bodies)) return;
  const ScopedSeconds timer(report.seconds_of(Phase::Detect));
  StepReport aside;
  const double dt = options.time_step;
  stage.find(parts, state.v, first_v, dt, {}, options, aside);
  const auto before = LevelShift::depths(stage.contacts());
  levels.mark(parts);
  stage.find(parts, state.v, first_v, dt, {}, options, aside);
  levels.shift().change(before, LevelShift::depths(stage.contacts()));
}

void World::Impl::measure(StepReport& report) {
  const ScopedSeconds timer(report.seconds_of(Phase::Advance));
  update_bodies();
  stage.rigid().keep(state.warm_start);
  if (sleep.on()) {
    // Linked bodies do not sleep: their links would have to be followed.
    std::vector<std::uint8_t> linked(bodies.size(), 0);
    for (std::size_t l = 0; l < links.size(); ++l)
      if (const auto [a, b] = links.bodies(l); !links.broken(l))
        for (const int body : {a, b})
          if (body >= 0) linked[static_cast<std::size_t>(body)] = 1, sleep.wake(static_cast<std::size_t>(body));
    const auto by_itself = [&](std::size_t b) { return driven(b, report.dt); };
    if (report.ok) sleep.settle(parts, report.pairs, report.dt, linked, by_itself, state.v, first_v);
    report.asleep = sleep.count();
  }
  keep_memory();
  measure_motion(report);
}

void World::Impl::measure_motion(StepReport& report) {
  if (!links.empty()) links.measure(parts, state.q, first_q, state.time, report);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    report.kinetic_energy += bodies[b]->kinetic_energy(v(b));
    report.potential_energy += bodies[b]->potential_energy(options.environment.scaled(actions.gravity_scale(), b));
  }
  for (const WorldPart& p : parts)
    if (!is_fixed(p)) report.max_speed = std::max(report.max_speed, speed_bound(p, v(p.body_index)));
}

}  // namespace brim
