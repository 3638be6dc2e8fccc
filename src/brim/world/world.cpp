#include "brim/world/world.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <unordered_set>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/stopwatch.h"
#include "brim/response/penalty.h"
#include "brim/world/applied_force.h"
#include "brim/world/attachment.h"
#include "brim/world/constraint_step.h"
#include "brim/world/contact_maps.h"
#include "brim/world/contact_stage.h"
#include "brim/world/fill_stage.h"
#include "brim/world/implicit_step.h"
#include "brim/world/levels.h"
#include "brim/world/links.h"
#include "brim/world/momentum_check.h"
#include "brim/world/outer_actions.h"
#include "brim/world/pair_laws.h"
#include "brim/world/pair_reports.h"
#include "brim/world/sleep.h"
#include "brim/world/space.h"
#include "brim/world/substeps.h"

namespace brim {

namespace {

/// Motion of a sub-step, over what is allowed, above which it is solved again in pieces.
constexpr double kOutrun = 1.25;
/// Tolerance of the solve where there are links, over the usual one: rigid ones rule the residual, and what it leaves
/// of softer motions would shake them.
constexpr double kLinked = 1e-2;

}  // namespace

struct World::Impl {
  WorldOptions options;
  std::vector<std::unique_ptr<Body>> bodies;
  std::unordered_set<std::string> names;
  std::vector<WorldPart> parts;
  std::vector<std::size_t> first_q{0}, first_v{0};
  State state;
  bool started = false;
  PairLaws laws;
  Sleep sleep;
  TouchRules rules;
  Links links;
  OuterActions actions;
  bool has_space = false;  ///< the last body and part stand for space
  Levels levels;

  ContactStage stage;
  FillStage fill;
  ContactMaps maps;
  Penalty response;
  ImplicitStep implicit;
  ConstraintStep constraints;
  std::vector<Vec3> velocity_a, velocity_b, normal_force, friction_force;
  std::vector<double> delta, before_q, before_v, travel;
  // The state that bodies were last updated to, and which have not been advanced since.
  std::vector<double> updated_q, updated_v;
  double updated_time = 0.0;
  std::vector<std::uint8_t> fresh;
  std::vector<ContactSample> samples;

  std::span<double> q(std::size_t b) { return std::span(state.q).subspan(first_q[b], first_q[b + 1] - first_q[b]); }
  std::span<double> v(std::size_t b) { return std::span(state.v).subspan(first_v[b], first_v[b + 1] - first_v[b]); }

  void start();
  /// Appends a body that is whole: what it throws has been thrown.
  void append(std::unique_ptr<Body> body, std::span<const double> q0, std::span<const double> v0);
  void show_space();
  void hide_space();
  std::size_t count() const { return bodies.size() - has_space; }  ///< of bodies that others see
  int find(const std::string& name) const;
  Links::Side side_of(int body);
  /// State of links and sleep comes out of memory, and goes back before all else in it.
  void take_memory();
  void keep_memory();
  void keep_apart();
  void update_bodies();
  /// Those that sleep are as they were; all others must be updated.
  void stir();
  void prescribe(double dt);
  /// Chooses the levels of a step, and eases over what changes with them.
  void choose_levels(StepReport& report);
  void find_contacts(double dt, StepReport& report);
  /// Wakes what something awake has contacts with. @return true where there was something
  bool wake_touched();
  double substep(double left, StepReport& report);
  bool solve_substep(double dt, StepReport& report);
  void measure(StepReport& report);
};

World::World(WorldOptions options) : impl_(std::make_unique<Impl>()) {
  const auto need = [](const char* what, double value, bool good) {
    if (!good) throw InputError(fmt::format("world: {} = {} is out of range", what, value));
  };
  need("time_step [s]", options.time_step, options.time_step > 0.0 && std::isfinite(options.time_step));
  need("voxel_size [m]", options.voxel_size, options.voxel_size >= 0.0 && std::isfinite(options.voxel_size));
  need("ramp_voxels", options.ramp_voxels, options.ramp_voxels >= 2.0 && options.ramp_voxels <= 4.0);
  need("stiffness [Pa]", options.stiffness, options.stiffness >= 0.0 && std::isfinite(options.stiffness));
  need("damping_steps", options.damping_steps, options.damping_steps >= 0.0 && std::isfinite(options.damping_steps));
  need("max_motion_voxels", options.max_motion_voxels,
       options.max_motion_voxels > 0.0 && options.max_motion_voxels <= 2.0);
  need("max_substeps", options.max_substeps, options.max_substeps >= 1);
  need("cg_tolerance", options.cg_tolerance, options.cg_tolerance > 0.0 && options.cg_tolerance < 1.0);
  impl_->options = std::move(options);
  for (const TouchRule& rule : impl_->options.touch_rules) impl_->rules.add(rule);
}

World::~World() = default;
World::World(World&&) noexcept = default;

int World::add(std::unique_ptr<Body> body) {
  Impl& w = *impl_;
  if (w.names.contains(body->name()))
    throw InputError(fmt::format("world: two bodies are named '{}'; names must be unique", body->name()));
  // All that may throw comes first.
  std::vector<double> q0(body->q_size()), v0(body->v_size());
  body->initial_state(q0, v0);
  body->update(w.state.time, q0, v0);
  std::vector<PartInfo> infos;
  for (int p = 0; p < body->part_count(); ++p) infos.push_back(body->part(p));
  w.names.insert(body->name());
  const bool space = w.has_space;
  if (space) w.hide_space();
  w.append(std::move(body), q0, v0);
  if (space) w.show_space();
  w.started = false;
  return static_cast<int>(w.count()) - 1;
}

void World::Impl::append(std::unique_ptr<Body> body, std::span<const double> q0, std::span<const double> v0) {
  state.q.insert(state.q.end(), q0.begin(), q0.end());
  state.v.insert(state.v.end(), v0.begin(), v0.end());
  first_q.push_back(state.q.size());
  first_v.push_back(state.v.size());
  for (int p = 0; p < body->part_count(); ++p)
    parts.push_back({body.get(), static_cast<int>(bodies.size()), p, 0.0, body->part(p)});
  bodies.push_back(std::move(body));
}

void World::Impl::show_space() {
  append(std::make_unique<Space>(), {}, {});
  has_space = true;
  started = false;
}

void World::Impl::hide_space() {
  bodies.pop_back(), parts.pop_back(), first_q.pop_back(), first_v.pop_back();
  has_space = false;
}

int World::Impl::find(const std::string& name) const {
  for (std::size_t b = 0; b < count(); ++b)
    if (bodies[b]->name() == name) return static_cast<int>(b);
  throw InputError(fmt::format("\"{}\" is not a body", name));
}

Links::Side World::Impl::side_of(int body) {
  Links::Side side;
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (parts[p].body_index == body) side.parts.push_back(static_cast<int>(p));
  side.q = q(static_cast<std::size_t>(body));
  return side;
}

void World::Impl::take_memory() {
  levels.take(state.memory, std::span(bodies).first(count()));
  links.take(state.memory);
  sleep.take(state.memory);
}

void World::Impl::keep_memory() {
  sleep.keep(state.memory);
  links.keep(state.memory);
  levels.keep(state.memory);
}

void World::Impl::keep_apart() {
  rules.clear_apart();
  for (std::size_t l = 0; l < links.size(); ++l)
    if (const auto [a, b] = links.bodies(l); !links.attachment(l).touch && b >= 0 && !links.broken(l))
      rules.keep_apart(a, b);
}

int World::attach(const Attachment& attachment) {
  Impl& w = *impl_;
  const int a = w.find(attachment.body), b = attachment.to.empty() ? -1 : w.find(attachment.to);
  w.start();
  w.update_bodies();
  const int number = w.links.add(attachment, w.parts, w.side_of(a), b < 0 ? Links::Side{} : w.side_of(b),
                                 w.options.ramp_voxels, w.state.time);
  if (w.links.needs_space() && !w.has_space) w.show_space();
  w.keep_apart();
  for (const int body : {a, b})
    if (body >= 0) wake(body);
  return number;
}

int World::attachment_count() const { return static_cast<int>(impl_->links.size()); }
const Attachment& World::attachment(int i) const { return impl_->links.attachment(static_cast<std::size_t>(i)); }
bool World::detached(int i) const { return impl_->links.broken(static_cast<std::size_t>(i)); }

void World::detach(int i) {
  Impl& w = *impl_;
  w.take_memory();
  w.links.set_broken(static_cast<std::size_t>(i), true);
  w.keep_memory();
  const auto [a, b] = w.links.bodies(static_cast<std::size_t>(i));
  for (const int body : {a, b})
    if (body >= 0) wake(body);
}

void World::set_drive(int i, double position, double velocity) {
  impl_->links.set_drive(static_cast<std::size_t>(i), position, velocity);
  wake(impl_->links.bodies(static_cast<std::size_t>(i)).first);
}

void World::set_touch(const TouchRule& rule) {
  Impl& w = *impl_;
  w.rules.add(rule);
  w.options.touch_rules.push_back(rule);
  for (WorldPart& p : w.parts) p.sides = w.rules.sides(p.body->name());
  for (std::size_t b = 0; b < w.count(); ++b) wake(static_cast<int>(b));
}

int World::apply(const AppliedForce& force) {
  Impl& w = *impl_;
  w.start();
  w.update_bodies();
  const int number = w.actions.add(force, w.bodies, w.parts, w.state.q, w.first_q, w.options.ramp_voxels);
  for (std::size_t b = 0; b < w.count(); ++b) wake(static_cast<int>(b));
  return number;
}

void World::set_gravity(const Vec3& gravity) {
  if (!gravity.allFinite()) throw InputError("world: gravity is not finite");
  impl_->options.environment.gravity = gravity;
  for (std::size_t b = 0; b < impl_->count(); ++b) wake(static_cast<int>(b));
}

int World::body_count() const { return static_cast<int>(impl_->count()); }
const Body& World::body(int b) const { return *impl_->bodies.at(b); }
int World::part_count() const { return static_cast<int>(impl_->parts.size() - impl_->has_space); }
PartRef World::part(int p) const { return {impl_->parts.at(p).body_index, impl_->parts.at(p).index}; }
std::span<const double> World::q(int b) const { return impl_->q(b); }
std::span<const double> World::v(int b) const { return impl_->v(b); }
const WorldOptions& World::options() const { return impl_->options; }
const State& World::state() const { return impl_->state; }
std::span<const ContactSample> World::contacts() const { return impl_->samples; }
std::span<const std::pair<TileKey, double>> World::active_tiles() const { return impl_->stage.active_tiles(); }

double World::stiffness() const {
  if (!impl_->started) impl_->start();
  return impl_->laws.stiffness();
}

void World::set_state(State state) {
  Impl& w = *impl_;
  if (state.q.size() != w.state.q.size() || state.v.size() != w.state.v.size())
    throw InputError(fmt::format("state: {} coordinates and {} velocities, but this world has {} and {}",
                                 state.q.size(), state.v.size(), w.state.q.size(), w.state.v.size()));
  w.start();  // what is chosen from the initial state stays as it was chosen there
  w.state = std::move(state);
  w.take_memory();
  w.levels.mark(w.parts);
  w.stage.average(w.levels.average());
  w.keep_apart();
  w.stage.rigid().restore(w.state.memory);
  for (std::size_t b = 0; b < w.bodies.size(); ++b)
    if (std::any_of(w.v(b).begin(), w.v(b).end(), [](double x) { return x != 0.0; })) w.sleep.wake(b);
  w.keep_memory();
  w.update_bodies();
}

bool World::asleep(int b) const { return impl_->sleep.asleep(static_cast<std::size_t>(b)); }

void World::wake(int b) {
  Impl& w = *impl_;
  if (!w.sleep.on()) return;
  w.take_memory();
  w.sleep.wake(static_cast<std::size_t>(b));
  w.keep_memory();
}

void World::density(int part, double h, std::span<const TileKey> tiles, std::span<DensityBlock> out) const {
  const WorldPart& p = impl_->parts.at(part);
  p.body->rasterize(p.index, h, impl_->options.ramp_voxels * h, tiles, out);
}

std::uint64_t World::hash() const {
  std::uint64_t hash = 0xcbf29ce484222325ull;  // FNV-1a
  const auto mix = [&](const void* data, std::size_t bytes) {
    const auto* c = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) hash = (hash ^ c[i]) * 0x100000001b3ull;
  };
  const State& s = impl_->state;
  mix(&s.time, sizeof s.time);
  mix(s.q.data(), s.q.size() * sizeof(double));
  mix(s.v.data(), s.v.size() * sizeof(double));
  mix(s.memory.data(), s.memory.size() * sizeof(double));
  return hash;
}

void World::Impl::start() {
  if (started) return;
  started = true;
  double h0 = options.voxel_size;
  if (h0 == 0.0) {
    for (const WorldPart& p : parts)
      if (p.info.voxel_size > 0.0 && (h0 == 0.0 || p.info.voxel_size < h0)) h0 = p.info.voxel_size;
    if (h0 == 0.0) h0 = 0.05;
  }
  for (WorldPart& p : parts) {
    const double wanted = p.info.voxel_size > 0.0 ? p.info.voxel_size : h0;
    const int level = std::max(0, static_cast<int>(std::floor(std::log2(wanted / h0) + 1e-9)));
    p.h = std::ldexp(h0, level);
  }
  for (WorldPart& p : parts) p.sides = rules.sides(p.body->name()), p.rules = &rules;
  laws.start(parts, state.v, first_v, options, h0);
  stage.rigid().start(parts, laws, options);
  if (options.sleep) sleep.start(bodies);
  stage.rigid().restore(state.memory);
}

void World::Impl::stir() {
  for (std::size_t b = 0; b < fresh.size(); ++b) fresh[b] &= sleep.asleep(b);
}

void World::Impl::update_bodies() {
  if (updated_q.size() != state.q.size() || updated_v.size() != state.v.size()) fresh.clear();
  if (updated_time != state.time) stir();
  updated_q.resize(state.q.size()), updated_v.resize(state.v.size()), fresh.resize(bodies.size(), 0);
  updated_time = state.time;
  // A step begins where the last was measured: what is known is not found again.
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
    w.start();
    report.stiffness = w.laws.stiffness();
    if (w.state.step == 0) w.laws.warn(w.parts, w.options, report);
    w.take_memory();
    if (w.levels.on()) w.choose_levels(report);
    if (w.sleep.on()) {
      w.sleep.mark(w.parts, w.state.v, w.first_v);
    }
    double left = w.options.time_step;
    const double end = w.state.time + left;
    while (report.ok && left > 1e-9 * w.options.time_step) left -= w.substep(left, report);
    w.state.time = end;
    ++w.state.step;
    w.measure(report);
  }
  report.time = w.state.time;
  if (w.levels.on()) w.levels.took(report.wall);
  return report;
}

void World::Impl::choose_levels(StepReport& report) {
  update_bodies();
  if (!levels.choose(state.step, bodies)) return;
  const ScopedSeconds timer(report.seconds[static_cast<std::size_t>(Phase::Detect)]);
  StepReport aside;
  const double dt = options.time_step;
  stage.find(parts, state.v, first_v, dt, options, aside);
  const auto before = LevelShift::depths(stage.contacts());
  levels.mark(parts);
  stage.find(parts, state.v, first_v, dt, options, aside);
  levels.shift().change(before, LevelShift::depths(stage.contacts()));
}

void World::Impl::prescribe(double dt) {
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    bodies[b]->prescribe(state.time, dt, q(b), v(b));
    if (sleep.asleep(b) && std::any_of(v(b).begin(), v(b).end(), [](double x) { return x != 0.0; })) sleep.wake(b);
  }
  if (sleep.on()) sleep.mark(parts, state.v, first_v);
}

bool World::Impl::wake_touched() {
  bool woke = false;
  const auto touch = [&](std::int32_t a, std::int32_t b) {
    const auto i = static_cast<std::size_t>(parts[a].body_index), j = static_cast<std::size_t>(parts[b].body_index);
    woke = sleep.wake(i) || woke;
    woke = sleep.wake(j) || woke;
  };
  // No two that sleep are looked at, nor one and something fixed that does not move.
  for (const ContactPair& p : stage.contacts().pairs)
    if (p.begin < p.end) touch(p.part_a, p.part_b);
  stage.rigid().for_pairs(touch);
  if (woke) sleep.mark(parts, state.v, first_v);
  return woke;
}

void World::Impl::find_contacts(double dt, StepReport& report) {
  do {
    stage.find(parts, state.v, first_v, dt, options, report);
    levels.shift().apply(stage.contacts());
    const ScopedSeconds timer(report.seconds[static_cast<std::size_t>(Phase::Detect)]);
    fill.find(bodies, parts, options, stage.contacts());
  } while (sleep.on() && wake_touched());
}

bool World::Impl::solve_substep(double dt, StepReport& report) {
  const auto seconds = [&](Phase p) -> double& { return report.seconds[static_cast<std::size_t>(p)]; };
  prescribe(dt);
  {
    const ScopedSeconds timer(seconds(Phase::Advance));
    update_bodies();
  }

  find_contacts(dt, report);
  if (!links.empty())
    links.append(parts, state.q, first_q, static_cast<int>(parts.size()) - 1, state.time, dt, stage.contacts());
  const ContactSet& contacts = stage.contacts();
  velocity_a.resize(contacts.size()), velocity_b.resize(contacts.size());
  {
    const ScopedSeconds timer(seconds(Phase::Respond));
    maps.build(parts, contacts, first_v);
    maps.velocities(state.v, velocity_a, velocity_b);
    laws.choose(parts, state.v, first_v, options, contacts.pairs);
    laws.leave_to_links(contacts.first_link_pair());
    const double g = options.environment.gravity.norm();
    PenaltyOptions p;
    p.dt = dt;
    p.damping = options.damping_steps * options.time_step;
    p.friction_speed =
        options.friction_speed > 0.0 ? options.friction_speed : std::max(1e-3 * g * options.time_step, 1e-9);
    p.release_speed = 0.2 * g * dt;
    p.slack = g * dt * dt;
    response.begin(contacts, laws.penalties(), p, velocity_a, velocity_b);
    fill.begin(bodies, first_v, state.v, velocity_a, velocity_b, dt, response);
    if (contacts.link_pairs > 0) links.begin(contacts, velocity_a, velocity_b, response);
  }

  {
    const ScopedSeconds timer(seconds(Phase::Respond));
    const double g = options.environment.gravity.norm();
    ConstraintStep::Settings s;
    s.rows = {dt, 2.0 * g * dt, options.constraint_every_node};
    s.tolerance = options.constraint_tolerance;
    s.max_sweeps = options.constraint_sweeps;
    s.scale = std::max(g * dt, 1e-6);
    constraints.begin(bodies, first_v, parts, contacts, response.normals(), laws.constraints(), stage.rigid().gather(),
                      state.v, s, ReferencePoses::rows_of(state.memory));
  }

  ImplicitStep::Settings settings;
  settings.dt = dt;
  settings.tolerance = (contacts.link_pairs > 0 ? kLinked : 1.0) * options.cg_tolerance;
  settings.max_iterations = options.cg_max_iterations;
  settings.passes = options.max_passes;
  std::vector<std::uint8_t> asleep(sleep.on() ? bodies.size() : 0);
  for (std::size_t b = 0; b < asleep.size(); ++b) asleep[b] = sleep.asleep(b);
  settings.asleep = asleep;
  delta.resize(state.v.size());
  std::span<const double> impulse = constraints.impulse();
  if (!actions.empty()) {
    settings.gravity_scale = actions.gravity_scale();
    impulse = actions.impulse(bodies, parts, state.q, first_q, state.v, first_v, options.environment, state.time, dt,
                              impulse);
  }
  ImplicitStep::Correct rows;
  if (!constraints.empty())
    rows = [&](const ImplicitStep::Respond& solve, std::span<double> change) {
      return constraints.correct(solve, change, report);
    };
  return implicit.solve(bodies, first_v, parts, options.environment, maps, response, contacts, state.v, settings, delta,
                        report, fill, impulse, rows);
}

double World::Impl::substep(double left, StepReport& report) {
  const auto seconds = [&](Phase p) -> double& { return report.seconds[static_cast<std::size_t>(p)]; };
  auto presence = std::make_optional<ScopedSeconds>(seconds(Phase::Presence));
  double dt = choose_substep(parts, state.v, first_v, options, left, report);
  presence.reset();
  before_q = state.q;
  before_v = state.v;
  const std::size_t warnings = report.warnings.size();
  bool finite = solve_substep(dt, report);
  // What contact throws may outrun the choice, which knows the speeds before only: cut again, once.
  if (finite && report.substeps + 1 < options.max_substeps) {
    travel = state.v;
    for (std::size_t i = 0; i < travel.size(); ++i) travel[i] += delta[i];
    presence.emplace(seconds(Phase::Presence));
    const double pieces = motion_pieces(parts, travel, first_v, options, dt, 0.0);
    presence.reset();
    if (pieces > kOutrun) {
      state.q = before_q;
      state.v = before_v;
      fresh.clear();
      report.warnings.erase(report.warnings.begin() + static_cast<std::ptrdiff_t>(warnings), report.warnings.end());
      dt /= std::ceil(pieces);
      finite = solve_substep(dt, report);
    }
  }
  ++report.substeps;
  const bool last = left - dt <= 1e-9 * options.time_step;
  const ContactSet& contacts = stage.contacts();
  report.contacts = static_cast<std::int64_t>(contacts.first_link()) + stage.rigid().contacts();
  if (!finite) {
    state.q = before_q;
    state.v = before_v;
    fresh.clear();
    report.ok = false;
    report.warnings.push_back(
        {state.time, "not_finite", "the solve gave values that are not finite; the state before it is kept"});
    return left;
  }

  {
    const ScopedSeconds timer(seconds(Phase::Respond));
    normal_force.resize(contacts.size()), friction_force.resize(contacts.size());
    response.forces(implicit.contact_delta(), normal_force, friction_force);
    fill.add_forces(normal_force);
    report_pairs(parts, contacts, normal_force, friction_force, state.time, report, samples);
    stage.rigid().report(parts, state.time, report);
    // Before stiff contact has pushed apart what lies within each other.
    if (state.step == 0 && report.substeps == 1) warn_of_start(parts, state.time, report);
    if (last) {
      for (std::size_t c = 0; c < contacts.size(); ++c) normal_force[c] += friction_force[c];
      check_momentum(bodies, first_v, parts, contacts, maps, normal_force, report);
    }
    if (!links.empty()) {
      links.finish(contacts, normal_force, state.time, report);
      keep_apart();
    }
    constraints.finish(report, samples, last, state.memory);
    report.contact_energy = response.energy();
  }
  const ScopedSeconds timer(seconds(Phase::Advance));
  for (std::size_t i = 0; i < state.v.size(); ++i) state.v[i] += delta[i];
  travel = state.v;
  for (std::size_t i = 0; i < constraints.travel().size(); ++i) travel[i] += constraints.travel()[i];
  parallel_for(bodies.size(), [&](std::size_t b) {
    if (sleep.asleep(b)) return;
    const ProfileScope scope("advance", *bodies[b]);
    bodies[b]->advance(dt, q(b), std::span<const double>(travel).subspan(first_v[b], first_v[b + 1] - first_v[b]));
    bodies[b]->finish_step(state.time, dt, q(b), v(b));
  });
  stir();
  levels.shift().pass(dt);
  state.time += dt;
  return dt;
}

void World::Impl::measure(StepReport& report) {
  const ScopedSeconds timer(report.seconds[static_cast<std::size_t>(Phase::Advance)]);
  update_bodies();
  stage.rigid().keep(state.memory);
  if (sleep.on()) {
    if (report.ok) sleep.settle(parts, report.pairs, report.dt, state.v, first_v);
    // What is linked does not sleep: its links would have to be followed.
    for (std::size_t l = 0; l < links.size(); ++l)
      if (const auto [a, b] = links.bodies(l); !links.broken(l)) {
        sleep.wake(static_cast<std::size_t>(a));
        if (b >= 0) sleep.wake(static_cast<std::size_t>(b));
      }
    report.asleep = sleep.count();
  }
  keep_memory();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    report.kinetic_energy += bodies[b]->kinetic_energy(v(b));
    report.potential_energy += bodies[b]->potential_energy(actions.environment(b, options.environment));
  }
  for (const WorldPart& p : parts)
    if (!p.body->immobile())
      report.max_speed = std::max(report.max_speed, p.body->carrier_velocity(p.index, v(p.body_index)).norm() +
                                                        p.body->relative_speed_bound(p.index, v(p.body_index)));
}

}  // namespace brim
