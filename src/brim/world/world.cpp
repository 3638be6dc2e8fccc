#include "brim/world/world.h"

#include <algorithm>
#include <atomic>

#include "brim/core/checked_index.h"
#include "brim/core/error.h"
#include "brim/world/given_values.h"
#include "brim/world/world_impl.h"

namespace brim {

World::World(WorldOptions options) : impl_(std::make_unique<Impl>()) {
  impl_->self = this;
  need_options(options);
  static std::atomic<std::uint64_t> worlds{0};
  impl_->own_number = ++worlds;
  impl_->note_wiring();
  impl_->given = options;
  impl_->options = std::move(options);
  for (const TouchRule& rule : impl_->options.touch_rules)
    impl_->rules.add(rule, rule.about_part() ? impl_->filter.add(rule) : -1);
}

World::~World() = default;
World::World(World&& other) noexcept { *this = std::move(other); }
World& World::operator=(World&& other) noexcept {
  impl_ = std::move(other.impl_);
  if (impl_ != nullptr) impl_->self = this;
  return *this;
}

int World::add(std::unique_ptr<Body> body) {
  if (body == nullptr) throw InputError("world: there is no body to add");
  Impl& w = *impl_;
  if (w.names.contains(body->name())) w.refuse_name(body->name());
  // Everything that may throw comes first.
  std::vector<double> q0(body->q_size()), v0(body->v_size());
  body->initial_state(q0, v0);
  need_coordinates("add", *body, q0, v0);
  need_parts(*body);
  body->update(w.state.time, q0, v0);
  std::vector<PartInfo> infos;
  for (int p = 0; p < body->part_count(); ++p) infos.push_back(body->part(p));
  w.names.insert(body->name());
  const bool space = w.has_space;
  w.started = false;
  if (space) w.hide_space();
  w.append(std::move(body), q0, v0);
  if (space) w.show_space();
  w.whole_is_old = true;
  return static_cast<int>(w.count()) - 1;
}

void World::Impl::refuse_name(const std::string& name) const {
  for (std::size_t b = 0; b < count(); ++b)
    if (own(b).name() == name && is_removed(b))
      throw InputError(
          fmt::format("world: '{}' is the name of a removed body, for which it stays reserved; use another", name));
  throw InputError(fmt::format("world: two bodies are named '{}'; names must be unique", name));
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

void World::Impl::take_memory() {
  for (const auto& w : watchers) w->take(state.warm_start);
  levels.take(state.warm_start, std::span(bodies).first(count()));
  edits.take(state.warm_start, static_cast<int>(count()));
  aims.take(state.warm_start, [this](int b) { return aimed(b); });
  motions.take(state.warm_start, [this](int b) { return aimed(b); });
  links.take(state.warm_start);
  sleep.take(state.warm_start);
}

void World::Impl::keep_memory() {
  sleep.keep(state.warm_start);
  links.keep(state.warm_start);
  motions.keep(state.warm_start);
  aims.keep(state.warm_start);
  edits.keep(state.warm_start);
  levels.keep(state.warm_start);
  for (std::size_t i = watchers.size(); i-- > 0;) watchers[i]->keep(*self, state.warm_start);
  whole_is_old = true;
}

void World::Impl::note_wiring() {
  auto wiring = std::make_shared<Wiring>();
  wiring->world = own_number;
  wiring->links = links.list(), wiring->forces = actions.list();
  for (std::size_t i = 0; i < links.kept(); ++i) wiring->link_names.push_back(links.attachment(i).name);
  for (std::size_t i = 0; i < actions.size(); ++i) wiring->force_names.push_back(actions.given(i).name);
  state.wiring = std::move(wiring);
  whole_is_old = true;
}

std::shared_ptr<const Wiring> World::Impl::wiring_of(const State& other) const {
  if (other.wiring == nullptr) return state.wiring;
  if (other.wiring->world == own_number) return other.wiring;
  const Wiring &wanted = *other.wiring, &here = *state.wiring;
  if (wanted.link_names == here.link_names && wanted.force_names == here.force_names) return state.wiring;
  auto out = std::make_shared<Wiring>();
  out->world = own_number, out->link_names = wanted.link_names, out->force_names = wanted.force_names;
  const auto pick = [](const auto& needed, const auto& known, const auto& from, auto& to, const char* what) {
    for (const std::string& name : needed) {
      const auto at = std::ranges::find(known, name);
      if (at == known.end())
        throw InputError(
            fmt::format("state: it has the {} '{}', which this world does not have; add it first", what, name));
      to.push_back(from[static_cast<std::size_t>(at - known.begin())]);
    }
  };
  pick(wanted.link_names, here.link_names, here.links, out->links, "attachment");
  pick(wanted.force_names, here.force_names, here.forces, out->forces, "force");
  return out;
}

void World::watch(std::unique_ptr<Watcher> watcher) {
  if (watcher == nullptr) throw InputError("watch: there is no watcher; give one");
  impl_->watchers.push_back(std::move(watcher));
}
std::span<const std::unique_ptr<Watcher>> World::watchers() const { return impl_->watchers; }

std::size_t World::Impl::body_index(int b, const char* what) const { return checked_index(b, count(), what, "body"); }
std::size_t World::Impl::part_index(int p, const char* what) const {
  return checked_index(p, parts.size() - has_space, what, "part");
}

int World::body_count() const { return static_cast<int>(impl_->count()); }
const Body& World::body(int b) const {
  const std::size_t i = impl_->body_index(b, "body");
  impl_->catch_up();
  return impl_->own(i);
}
int World::part_count() const { return static_cast<int>(impl_->parts.size() - impl_->has_space); }
PartRef World::part(int p) const {
  const WorldPart& part = impl_->parts[impl_->part_index(p, "part")];
  return {part.body_index, part.index};
}
std::span<const double> World::q(int b) const {
  const std::size_t i = impl_->body_index(b, "q");
  impl_->catch_up();
  return impl_->kept_q(i);
}
std::span<const double> World::v(int b) const {
  const std::size_t i = impl_->body_index(b, "v");
  impl_->catch_up();
  return impl_->kept_v(i);
}
const WorldOptions& World::options() const {
  impl_->catch_up();
  return impl_->options;
}
const State& World::state() const {
  impl_->catch_up();
  return impl_->whole_state();
}
std::span<const ContactSample> World::contacts() const { return impl_->samples; }
std::span<const std::pair<TileKey, double>> World::active_tiles() const { return impl_->stage.active_tiles(); }

double World::stiffness() const {
  impl_->start();
  return impl_->stiffness();
}

void World::set_state(State state) {
  Impl& w = *impl_;
  const State& now = this->state();
  if (state.q.size() != now.q.size() || state.v.size() != now.v.size())
    throw InputError(fmt::format("state: {} coordinates and {} velocities, but this world has {} and {}",
                                 state.q.size(), state.v.size(), now.q.size(), now.v.size()));
  std::span<const double> q = state.q, v = state.v;
  for (std::size_t b = 0; b < w.count(); ++b) {
    const Body& body = w.own(b);
    need_coordinates("state", body, q.first(body.q_size()), v.first(body.v_size()));
    q = q.subspan(body.q_size()), v = v.subspan(body.v_size());
  }
  std::shared_ptr<const Wiring> wiring = w.wiring_of(state);
  w.start();  // choices based on the initial state stay as made there
  std::vector<double> before, after;
  w.edits.keep(before);
  w.bring_back();
  if (wiring != w.state.wiring) w.links.set_list(wiring->links), w.actions.set_list(wiring->forces);
  w.state = std::move(state);
  w.state.wiring = std::move(wiring);
  w.take_memory();
  w.leave_out();
  w.edits.keep(after);
  if (before != after) w.follow_edits();
  w.levels.mark(w.parts);
  w.stage.average(w.levels.average());
  w.keep_apart();
  w.stage.rigid().restore(w.state.warm_start);
  for (const int b : w.edits.frozen) std::ranges::fill(w.v(static_cast<std::size_t>(b)), 0.0);
  for (std::size_t b = 0; b < w.bodies.size(); ++b)
    if (std::any_of(w.v(b).begin(), w.v(b).end(), [](double x) { return x != 0.0; })) w.sleep.wake(b);
  w.keep_memory();
  w.update_bodies();
  // Results for the previous state are invalid.
  w.samples.clear();
  w.stage.forget();
  for (const auto& watcher : w.watchers) watcher->restored(*this);
}

bool World::asleep(int b) const { return impl_->sleep.asleep(impl_->body_index(b, "asleep")); }

void World::wake(int b) { impl_->wake(impl_->body_index(b, "wake")); }

double World::voxel_size(int part) const {
  const std::size_t p = impl_->part_index(part, "voxel_size");
  impl_->start();
  return impl_->parts[p].h;
}

void World::density(int part, double h, std::span<const TileKey> tiles, std::span<DensityBlock> out) const {
  const WorldPart& p = impl_->parts[impl_->part_index(part, "density")];
  impl_->catch_up();
  if (impl_->out(static_cast<std::size_t>(p.body_index)))
    for (DensityBlock& block : out) std::ranges::fill(block.rho, 0.0), std::ranges::fill(block.source, 0);
  p.body->rasterize(p.index, h, impl_->options.ramp_voxels * h, tiles, out);
}

std::uint64_t World::hash() const {
  std::uint64_t hash = 0xcbf29ce484222325ull;  // FNV-1a
  const auto mix = [&](const void* data, std::size_t bytes) {
    const auto* c = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) hash = (hash ^ c[i]) * 0x100000001b3ull;
  };
  const State& s = state();
  mix(&s.time, sizeof s.time);
  mix(s.q.data(), s.q.size() * sizeof(double));
  mix(s.v.data(), s.v.size() * sizeof(double));
  mix(s.warm_start.data(), s.warm_start.size() * sizeof(double));
  return hash;
}

}  // namespace brim
