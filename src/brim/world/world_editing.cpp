#include <algorithm>
#include <cmath>

#include "brim/body/kinematic.h"
#include "brim/body/movable.h"
#include "brim/core/error.h"
#include "brim/world/attachment.h"
#include "brim/world/body_motion.h"
#include "brim/world/given_values.h"
#include "brim/world/world_impl.h"

namespace brim {

namespace {

/// Shares of a velocity that is set: by which the momentum may miss it, and of kinetic energy that is no rotation.
constexpr double kMomentumMissed = 1e-6, kNoMotion = 1e-12;

bool is_driven(const Body& body) {
  const auto* movable = dynamic_cast<const Movable*>(&body);
  return movable != nullptr && movable->driven();
}

/// True for a finite place and a rotation.
bool is_placement(const Pose& pose) {
  return pose.translation.allFinite() && pose.rotation.allFinite() &&
         (pose.rotation * pose.rotation.transpose()).isApprox(Mat3::Identity(), 1e-6) &&
         !(pose.rotation.determinant() < 0.0);
}

}  // namespace

void World::Impl::need(int b, const char* what) const {
  const std::size_t i = body_index(b, what);
  if (is_removed(i)) throw InputError(fmt::format("{}: '{}' was removed", what, own(i).name()));
}

void World::Impl::edit(const std::function<void(Edits&)>& change) {
  if (!started) start();
  take_memory();
  change(edits);
  keep_memory();
  edited = true;
}

void World::Impl::wake_around(int b) {
  const auto i = static_cast<std::size_t>(b);
  if (own(i).immobile() || is_frozen(i))
    wake_all();
  else
    wake(i);
}

void World::Impl::wake_all() {
  if (!sleep.on() || sleep.count() == 0) return;
  take_memory();
  for (std::size_t b = 0; b < count(); ++b) sleep.wake(b);
  keep_memory();
}

void World::Impl::wake(std::size_t b) {
  if (!sleep.asleep(b)) return;
  take_memory();
  sleep.wake(b);
  keep_memory();
}

void World::remove(int b) {
  Impl& w = *impl_;
  w.need(b, "remove");
  if (!w.started) w.start();
  w.wake_around(b);
  if (grabbed() == b) release();
  w.edit([&](Edits& edits) {
    edits.removed.insert(b);
    for (std::size_t l = 0; l < w.links.size(); ++l)
      if (const auto [i, j] = w.links.bodies(l); i == b || j == b) w.links.set_broken(l, true);
  });
}

bool World::removed(int b) const { return impl_->is_removed(impl_->body_index(b, "removed")); }

void World::freeze(int b, bool frozen) {
  Impl& w = *impl_;
  w.need(b, "freeze");
  if (w.is_frozen(static_cast<std::size_t>(b)) == frozen) return;
  if (const Body& body = w.own(static_cast<std::size_t>(b)); frozen && is_driven(body))
    throw InputError(fmt::format("freeze: '{}' follows keyframes; it cannot be frozen", body.name()));
  if (!w.started) w.start();
  w.wake_around(b);
  std::ranges::fill(w.v(static_cast<std::size_t>(b)), 0.0);
  w.edit([&](Edits& edits) {
    if (frozen)
      edits.frozen.insert(b);
    else
      edits.frozen.erase(b);
  });
}

bool World::frozen(int b) const { return impl_->is_frozen(impl_->body_index(b, "frozen")); }

void World::move(int b, const Pose& by) {
  Impl& w = *impl_;
  w.need(b, "move");
  const Body& body = this->body(b);
  const auto refuse = [&](const std::string& why) { throw InputError(fmt::format("move: '{}' {}", body.name(), why)); };
  if (!is_placement(by)) refuse("must be moved by finite numbers and a rotation");
  if (const std::string why = refuses_move(body, by.rotation); !why.empty()) refuse(why);
  w.start();
  if (grabbed() == b) refuse("is grabbed; release it first");
  for (std::size_t l = 0; l < w.links.size(); ++l)
    if (const auto [i, j] = w.links.bodies(l); !w.links.broken(l) && (i == b || j == b))
      refuse(fmt::format("is held by '{}'; detach it first", w.links.attachment(l).name));
  w.wake_around(b);
  if (moves_by_base(body)) {
    w.edit([&](Edits& edits) {
      Pose& base = edits.bases[b];
      base = {by.rotation * base.rotation, by.rotation * base.translation + by.translation};
    });
    return;
  }
  dynamic_cast<const Movable&>(body).move(by, w.q(static_cast<std::size_t>(b)), w.v(static_cast<std::size_t>(b)));
  w.whole_is_old = true;
  w.update_bodies();
}

void World::set_velocity(int b, const Vec3& velocity, const Vec3& angular_velocity) {
  Impl& w = *impl_;
  w.need(b, "set_velocity");
  const Body& body = this->body(b);
  const auto refuse = [&](const char* why) {
    throw InputError(fmt::format("set_velocity: '{}' {}", body.name(), why));
  };
  if (!velocity.allFinite() || !angular_velocity.allFinite()) refuse("needs finite numbers");
  if (frozen(b)) refuse("is frozen; let it go first");
  if (dynamic_cast<const Kinematic*>(&body) != nullptr) {
    KinematicMotion motion;
    motion.velocity = velocity, motion.spin = angular_velocity;
    w.drive(b, motion);
    return;
  }
  if (body.immobile()) refuse("is fixed");
  w.start();
  w.update_bodies();
  std::vector<double> v(body.v_size());
  if (!body.rigid_motion(velocity, Vec3::Zero(), v)) refuse("cannot move as a whole; set its v");
  const std::optional<Vec3> center = center_of_mass(body);
  if (!center) refuse("has no centre of mass");
  // A body of few coordinates gives its best try: what it cannot do is told, not left out.
  double size = 0.0;
  for (int p = 0; p < body.part_count(); ++p) size = std::max(size, body.bounds(p).extent().maxCoeff());
  const double mass = body.mass(), turning = size * angular_velocity.norm();
  body.rigid_motion(-angular_velocity.cross(*center), angular_velocity, v);
  if (turning > 0.0 && !(body.kinetic_energy(v) > kNoMotion * mass * turning * turning))
    refuse("has no coordinates that turn it so; set its v");
  body.rigid_motion(velocity - angular_velocity.cross(*center), angular_velocity, v);
  if (!((body.linear_momentum(v) - mass * velocity).norm() <=
        kMomentumMissed * mass * std::max(velocity.norm(), turning)))
    refuse("has no coordinates that move it so; set its v");
  body.filter(v);
  w.wake_around(b);
  std::ranges::copy(v, w.v(static_cast<std::size_t>(b)).begin());
  w.whole_is_old = true;
  w.update_bodies();
}

void World::set_target(int b, const Pose& pose, double duration) {
  Impl& w = *impl_;
  w.need(b, "set_target");
  const Body& body = this->body(b);
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("set_target: '{}' {}", body.name(), why));
  };
  if (dynamic_cast<const Kinematic*>(&body) == nullptr)
    refuse(fmt::format("({}) moves by forces; obstacles are driven", body.kind()));
  if (frozen(b)) refuse("is frozen; let it go first");
  if (!is_placement(pose)) refuse("needs a pose of finite numbers and a rotation");
  if (!(duration >= 0.0) || !std::isfinite(duration))
    refuse(fmt::format("is not driven for {} s; must be a number from 0", duration));
  KinematicMotion motion;
  motion.to_pose = true;
  motion.position = pose.translation, motion.rotation = Quat(pose.rotation).normalized();
  motion.at = w.state.time + (duration > 0.0 ? duration : w.options.time_step);
  w.drive(b, motion);
}

void World::Impl::drive(int b, const KinematicMotion& motion) {
  const auto i = static_cast<std::size_t>(b);
  start();
  wake_all();
  take_memory();
  motions.set(b, motion, [this](int n) { return aimed(n); });
  keep_memory();
  // The choice of the next sub-step sees how fast it moves.
  bodies[i]->prescribe(state.time, options.time_step, q(i), v(i));
  whole_is_old = true;
  update_bodies();
}

void World::set_material(int b, const Material& material) {
  impl_->need(b, "set_material");
  need_material(fmt::format("material '{}' of '{}'", material.name, impl_->own(static_cast<std::size_t>(b)).name()),
                material);
  if (!impl_->started) impl_->start();
  impl_->wake_around(b);
  impl_->edit([&](Edits& edits) { edits.materials[b] = material; });
}

Material World::material(int b, int part) const {
  for (const WorldPart& p : impl_->parts)
    if (p.body_index == b && p.index == part) {
      const auto it = impl_->edits.materials.find(b);
      return it != impl_->edits.materials.end() ? it->second
                                                : impl_->own(static_cast<std::size_t>(b)).part(part).material;
    }
  throw InputError(fmt::format("material: body {} has no part {}", b, part));
}

void World::set_pair_material(const std::string& a, const std::string& b, const PairMaterial& pair) {
  need_pair_material(fmt::format("materials '{}' and '{}'", a, b), pair);
  impl_->edit([&](Edits& edits) { edits.pairs[std::minmax(a, b)] = pair; });
  impl_->wake_all();
}

void World::set_stiffness(double stiffness) {
  if (!(stiffness > 0.0) || !std::isfinite(stiffness))
    throw InputError(fmt::format("world: stiffness {} is not allowed; must be a number above 0 [Pa]", stiffness));
  impl_->edit([&](Edits& edits) { edits.stiffness = stiffness; });
  impl_->wake_all();
}

void World::set_gravity(const Vec3& gravity) {
  if (!gravity.allFinite()) throw InputError("world: gravity is not finite");
  impl_->edit([&](Edits& edits) { edits.gravity = gravity; });
  impl_->wake_all();
}

void World::set_touch(const TouchRule& rule) {
  impl_->catch_up();
  TouchRules more = impl_->rules;
  more.add(rule);  // throws when there are too many
  int region = -1;
  if (rule.about_part()) {
    impl_->start();
    impl_->update_bodies();
    PartFilter with = impl_->filter;
    region = with.add(rule);
    with.meet(std::span(impl_->bodies).first(impl_->count()));  // throws when a body carries no region along
    impl_->filter = std::move(with);
  }
  if (!impl_->started && impl_->state.step == 0 && region < 0) {
    // As if the world had been constructed with it: not an edit that setting a state would undo.
    for (auto* rules : {&impl_->given.touch_rules, &impl_->options.touch_rules}) {
      // Those about parts are numbered by their order.
      std::erase_if(*rules, [&](const TouchRule& r) { return !r.about_part() && r.overruled_by(rule); });
      rules->push_back(rule);
    }
    impl_->rules = std::move(more);
    return;
  }
  impl_->edit([&](Edits& edits) {
    std::erase_if(edits.rules, [&](const Edits::Rule& r) { return r.rule.overruled_by(rule); });
    edits.rules.push_back({rule, region});
  });
  impl_->wake_all();
}

// ---- scheduled edits -----------------------------------------------------------------------------------------------

void World::schedule(double at, std::function<void(World&)> edit) {
  if (edit == nullptr) throw InputError(fmt::format("an edit at time {} does nothing: its function is empty", at));
  if (!std::isfinite(at)) throw InputError(fmt::format("an edit cannot be at time {}", at));
  auto& all = impl_->scheduled;
  const auto after = std::ranges::upper_bound(all, at, {}, &Impl::Scheduled::at);
  all.insert(after, {at, std::move(edit)});
}

void World::Impl::run_scheduled(World& world, StepReport& report) {
  const double dt = options.time_step, slack = 1e-9 * dt;
  for (std::size_t i = 0; i < scheduled.size(); ++i) {
    const double at = scheduled[i].at;
    if (at > state.time + slack || (state.step > 0 && at <= state.time - dt + slack)) continue;
    try {
      const auto edit = scheduled[i].edit;  // it may schedule others
      edit(world);
    } catch (const InputError& e) {
      report.warnings.push_back({state.time, "edit_refused", e.what()});
    }
  }
}

}  // namespace brim
