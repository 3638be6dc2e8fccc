#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "brim/body/guided_particles.h"
#include "brim/body/idle_velocities.h"
#include "brim/body/rigid_frame.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/stopwatch.h"
#include "brim/world/implicit_step.h"
#include "brim/world/islands.h"

namespace brim {

namespace {

/// Share of the velocities whose change is rounding: without forces, the solve need not resolve it.
constexpr double kNegligible = 1e-11;
/// Factor on the tolerance of an island with links: rigid ones dominate the residual, and its error in softer motions
/// would make these vibrate.
constexpr double kLinked = 1e-2;
/// Overlap above which a particle on a fixed part is guided by it: rows hold it close to contact.
constexpr float kGuided = -0.1f;

}  // namespace

bool ImplicitStep::solve_frames(std::span<double> delta) {
  const StepContext& c = *context_;
  for (const auto& body : c.bodies)
    if (body->v_size() > 0 && interface_of<RigidFrame>(*body) == nullptr) return false;
  parallel_for(
      c.bodies.size(),
      [&](std::size_t b) {
        const std::size_t first = c.first_v[b];
        if (c.first_v[b + 1] == first) return;  // space
        const ProfileScope scope("elements", *c.bodies[b]);
        using Six = Eigen::Matrix<double, 6, 1>;
        Eigen::Map<Six> change(delta.data() + first);
        change.setZero();
        if (unmoved(b)) return;
        Six force = Six::Zero();
        c.bodies[b]->begin_solve(settings_->dt);
        c.bodies[b]->add_forces(c.environment.scaled(settings_->gravity_scale, b), {force.data(), 6});
        force *= settings_->dt;
        if (!c.impulse.empty()) force += Eigen::Map<const Six>(c.impulse.data() + first);
        const RigidFrame::Frame f = interface_of<RigidFrame>(*c.bodies[b])->rigid_frame();
        change << f.inverse_mass * force.head<3>(), f.inverse_inertia * force.tail<3>();
      },
      64);
  return true;
}

void ImplicitStep::guide() {
  const StepContext& c = *context_;
  const auto tell = [&](auto chosen, auto set) {
    // Particles reached by a force at one of these contacts.
    contact_force_.assign(c.contacts.size(), Vec3::Zero());
    bool any = false;
    for (std::size_t p = 0; p < c.contacts.pairs.size(); ++p)
      for (std::size_t i = c.contacts.pairs[p].begin; i < c.contacts.pairs[p].end; ++i)
        if (chosen(p, i)) contact_force_[i] = Vec3::Ones(), any = true;
    if (!any) return;
    scratch_.assign(c.first_v.back(), 0.0);
    c.maps.add_forces(contact_force_, scratch_);
    std::vector<std::uint8_t> flags;
    for (std::size_t b = 0; b < c.bodies.size(); ++b) {
      auto* body = interface_of<GuidedParticles>(*c.bodies[b]);
      if (body == nullptr) continue;
      const auto reached = c.slice(scratch_, b);
      flags.assign(reached.size() / 3, 0);
      bool touched = false;
      for (std::size_t i = 0; i < flags.size(); ++i)
        if (reached[3 * i] != 0.0) flags[i] = 1, touched = true;
      if (touched) set(*body, flags);
    }
  };
  tell([&](std::size_t p, std::size_t i) { return c.response.guides(p) && c.contacts.overlap[i] > kGuided; },
       [](GuidedParticles& body, const std::vector<std::uint8_t>& flags) { body.set_guided(flags); });
  tell([&](std::size_t p, std::size_t) { return p >= c.contacts.first_link_pair(); },
       [](GuidedParticles& body, const std::vector<std::uint8_t>& flags) { body.set_linked(flags); });
}

void ImplicitStep::begin_bodies() {
  parallel_for(context_->bodies.size(), [&](std::size_t b) {
    if (unmoved(b)) return;
    const ProfileScope scope("elements", *context_->bodies[b]);
    context_->bodies[b]->begin_solve(settings_->dt);
  });
  gather_bodies();
}

void ImplicitStep::gather_bodies() {
  const StepContext& c = *context_;
  const double dt = settings_->dt;
  const std::size_t n = c.v.size();
  // Internal forces: dt (Q + dt ∂Q/∂q v), and the matrices of the bodies.
  internal_.assign(n, 0.0), scratch_.assign(n, 0.0);
  parallel_for(c.bodies.size(), [&](std::size_t b) {
    if (unmoved(b)) return;
    Body& body = *c.bodies[b];
    const ProfileScope scope("elements", body);
    body.add_forces(c.environment.scaled(settings_->gravity_scale, b), c.slice(internal_, b));
    if (c.fill.handles(b))
      c.fill.add_start_stiffness(b, c.slice(scratch_, b));
    else if (const auto* guided = interface_of<GuidedParticles>(body))
      guided->apply_start_stiffness(c.slice(c.v, b), c.slice(scratch_, b));
    else
      body.apply_stiffness(c.slice(c.v, b), c.slice(scratch_, b));
  });
  for (std::size_t i = 0; i < n; ++i)
    internal_[i] = dt * (internal_[i] + dt * scratch_[i]) + (c.impulse.empty() ? 0.0 : c.impulse[i]);
  if (FluidDrag& drag = c.coupling.drag(); !c.coupling.empty()) {
    drag.begin(c.v, c.first_v);
    drag.add_impulse(dt, c.v, internal_);
  }
  for (std::size_t i = 0; i < taken_.size(); ++i) internal_[i] += taken_[i];

  std::vector<int> sizes;
  first_block_.assign(1, 0);
  for (const auto& body : c.bodies) {
    const std::vector<int> s = body->block_sizes();
    sizes.insert(sizes.end(), s.begin(), s.end());
    first_block_.push_back(sizes.size());
  }
  bodies_diagonal_.reset(sizes);
  parallel_for(c.bodies.size(), [&](std::size_t b) {
    if (unmoved(b)) return;
    c.bodies[b]->add_system_diagonal(first_block_[b], bodies_diagonal_);
    const auto air = resistance(b);
    for (std::size_t i = 0; i < air.size(); ++i) bodies_diagonal_.block(first_block_[b] + i) += dt * air[i];
  });
}

void ImplicitStep::find_islands() {
  const StepContext& c = *context_;
  Islands islands(c.bodies.size());
  const auto moves = [&](const WorldPart& p) {
    return !is_fixed(p) && !unmoved(static_cast<std::size_t>(p.body_index));
  };
  for (const ContactPair& pair : c.contacts.pairs)
    if (moves(c.parts[pair.part_a]) && moves(c.parts[pair.part_b]))
      islands.join(c.parts[pair.part_a].body_index, c.parts[pair.part_b].body_index);
  c.coupling.for_pairs([&](int fluid, int solid) {
    if (!c.bodies[solid]->immobile() && !unmoved(static_cast<std::size_t>(solid))) islands.join(fluid, solid);
  });
  island_ = islands.numbers();
  sharpness_.assign(island_.empty() ? 0 : 1 + static_cast<std::size_t>(*std::ranges::max_element(island_)), 1.0);
  for (std::size_t p = c.contacts.first_link_pair(); p < c.contacts.pairs.size(); ++p)
    for (const int part : {c.contacts.pairs[p].part_a, c.contacts.pairs[p].part_b})
      sharpness_[island_[c.parts[part].body_index]] = kLinked;
  negligible_.assign(sharpness_.size(), 0.0);
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    negligible_[island_[b]] += kNegligible * kNegligible * 2.0 * c.bodies[b]->kinetic_energy(c.slice(c.v, b));
}

void ImplicitStep::begin_system() {
  const StepContext& c = *context_;
  find_islands();
  system_.first = c.first_v, system_.island = island_, system_.negligible = negligible_;
  system_.sharpness = sharpness_;
  idle_.clear();
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    if (const auto* body = interface_of<IdleVelocities>(*c.bodies[b]))
      for (const auto& [begin, end] : body->idle_velocities())
        idle_.push_back({c.first_v[b] + begin, c.first_v[b] + end});
  system_.idle = idle_;
  system_.filter = [this](std::span<double> x) { filter_bodies(x, [](std::size_t) { return false; }); };
  system_.apply = [this](std::span<const double> x, std::span<double> y) { multiply(x, y); };
  system_.precondition = [this](std::span<const double> r, std::span<double> z) { precondition(r, z); };
  invert_ = [this](std::span<const double> r, std::span<double> z, FluidCoupling::Of of) {
    const bool solids = of == FluidCoupling::Of::Solids;
    const auto left_out = [&](std::size_t b) { return solids && context_->coupling.flows(b); };
    filtered_.resize(r.size());
    for (std::size_t b = 0; b < context_->bodies.size(); ++b)
      if (!left_out(b)) std::ranges::copy(context_->slice(r, b), context_->slice(filtered_, b).begin());
    filter_bodies(filtered_, left_out);
    precondition_bodies(filtered_, z, left_out);
    filter_bodies(z, left_out);
  };
}

template <class F>
void ImplicitStep::filter_bodies(std::span<double> x, const F& left_out) const {
  parallel_for(context_->bodies.size(), [&](std::size_t b) {
    if (left_out(b)) return;
    const auto xb = context_->slice(x, b);
    if (unmoved(b))
      std::fill(xb.begin(), xb.end(), 0.0);
    else
      context_->bodies[b]->filter(xb);
  });
}

void ImplicitStep::multiply(std::span<const double> x, std::span<double> y) {
  const StepContext& c = *context_;
  if (contacts_ > 0) {
    const ScopedSeconds contact_timer(contact_seconds());
    acting_.take_velocities(x);
    if (!c.fill.empty())
      acting_.for_taken(c.fill.first(), [&](std::size_t i, const Vec3& d) {
        if (c.fill.holds(i)) c.fill.see(i, d);
      });
  }
  parallel_for(c.bodies.size(), [&](std::size_t b) {
    const ProfileScope scope("product", *c.bodies[b]);
    const auto yb = c.slice(y, b);
    std::fill(yb.begin(), yb.end(), 0.0);
    if (unmoved(b) || cg_.solved(b)) return;
    if (c.fill.handles(b))
      c.fill.apply_system(b, c.slice(x, b), yb);
    else
      c.bodies[b]->apply_system(c.slice(x, b), yb);
    const auto air = resistance(b);
    for (std::size_t i = 0; i < air.size(); ++i)
      Eigen::Map<Vec3>(yb.data() + 3 * i) +=
          settings_->dt * (air[i] * Eigen::Map<const Vec3>(x.data() + c.first_v[b] + 3 * i));
  });
  if (!c.coupling.empty()) c.coupling.drag().add_product(settings_->dt, x, y);
  if (contacts_ == 0) return;
  const ScopedSeconds contact_timer(contact_seconds());
  const ProfileScope scope("contact product");
  acting_.answer(
      [&](std::size_t i, const Vec3& d) {
        return c.fill.holds(i) ? Vec3(c.response.apply(i, d) - c.fill.impulse(i)) : c.response.apply(i, d);
      },
      y);
}

void ImplicitStep::begin_preconditioner() {
  const StepContext& c = *context_;
  const std::size_t bodies = c.bodies.size();
  std::vector<std::uint8_t> untouched(bodies, 1);
  if (contacts_ > 0)
    for (const ContactPair& pair : c.contacts.pairs)
      for (const int part : {pair.part_a, pair.part_b}) untouched[c.parts[part].body_index] = 0;
  c.coupling.set_untouched(untouched);
  invert_coupled(untouched);
  begin_contact_preconditioner();
  whole_ = contacts_ > 0 && preconditioner_.knows_all_rigid();
  coarse_ = contacts_ > 0 && !whole_;
  lone_.resize(bodies);
  for (std::size_t b = 0; b < bodies; ++b)
    lone_[b] = contacts_ > 0
                   ? preconditioner_.rigid()[b]
                   : first_block_[b + 1] == first_block_[b] + 1 && bodies_diagonal_.block_size(first_block_[b]) == 6;
  if (!whole_ && !alone_) {
    const auto contact_timer =
        contacts_ > 0 ? std::make_optional<ScopedSeconds>(contact_seconds()) : std::optional<ScopedSeconds>();
    const ProfileScope scope("coarse modes, made");
    without_ = lone_;
    for (std::size_t b = 0; b < bodies; ++b)
      if (unmoved(b) || c.coupling.flows(b)) without_[b] = 1;
    modes_.begin(c.bodies, c.first_v, c.parts, without_);
  }
  if (contacts_ > room_) {
    // Memory depends on the number of contacts, not on which of them are active.
    const ScopedSeconds contact_timer(contact_seconds());
    acting_.build(c.parts, c.contacts, c.first_v);
    preconditioner_.reserve(acting_);
    room_ = contacts_;
  }
}

void ImplicitStep::begin_contact_preconditioner() {
  const StepContext& c = *context_;
  fresh_ = true;
  if (contacts_ == 0) return;
  const ScopedSeconds contact_timer(contact_seconds());
  sparse_.resize(c.bodies.size());
  for (std::size_t b = 0; b < c.bodies.size(); ++b) sparse_[b] = c.maps.sparse_rows(b);
  preconditioner_.begin(c.bodies, c.first_v, bodies_diagonal_, first_block_, sparse_, island_, settings_->unmoved);
}

void ImplicitStep::invert_coupled(std::span<const std::uint8_t> untouched) {
  const StepContext& c = *context_;
  inverted_.assign(c.coupling.empty() ? 0 : c.bodies.size(), 0);
  if (inverted_.empty()) return;
  c.coupling.for_pairs([&](int, int solid) {
    const Body& body = *c.bodies[solid];
    const bool alone = untouched[solid] != 0 && !body.immobile() && !unmoved(static_cast<std::size_t>(solid));
    if (alone && body.block_system()) inverted_[solid] = 3;
  });
  const ProfileScope scope("coupled bodies, factored");
  inverses_.begin(c.bodies, c.first_v, inverted_);
}

void ImplicitStep::prepare() {
  const StepContext& c = *context_;
  const bool first = std::exchange(fresh_, false);
  plain_ = false;
  diagonal_ = bodies_diagonal_;
  if (contacts_ > 0) {
    const ScopedSeconds contact_timer(contact_seconds());
    acting_.add_block_diagonal([&](std::size_t i) { return c.response.block(i); }, first_block_, diagonal_);
  }
  parallel_for(c.bodies.size(), [&](std::size_t b) {
    if (!unmoved(b)) c.bodies[b]->prepare_preconditioner(first_block_[b], diagonal_);
  });
  diagonal_.factor();
  c.coupling.renew();
  if (contacts_ == 0) return;
  const ScopedSeconds contact_timer(contact_seconds());
  coarse_ = false;
  const auto beside = [&] {
    const ProfileScope scope("coarse modes, factored");
    coarse_ = modes_.factor(c.maps, c.contacts, c.response);
  };
  preconditioner_.make(acting_, c.response, first, whole_ ? std::function<void()>() : beside);
}

void ImplicitStep::precondition(std::span<const double> r, std::span<double> z) {
  if (context_->coupling.all_done([&](std::size_t b) { return cg_.solved(b); })) {
    precondition_bodies(r, z, [&](std::size_t b) { return cg_.solved(b); });
    return;
  }
  resisted_.assign(r.begin(), r.end());
  context_->coupling.resist(invert_, resisted_);
  invert_(resisted_, z, FluidCoupling::Of::All);
}

template <class F>
void ImplicitStep::precondition_bodies(std::span<const double> r, std::span<double> z, const F& left_out) {
  const StepContext& c = *context_;
  parallel_for(c.bodies.size(), [&](std::size_t b) {
    if (left_out(b)) return;
    const ProfileScope scope("precondition", *c.bodies[b]);
    const auto zb = c.slice(z, b);
    if (unmoved(b) || (coarse_ && modes_.complete(b)))
      std::fill(zb.begin(), zb.end(), 0.0);
    else if (!inverted_.empty() && inverted_[b] != 0 && inverses_.exact(b))
      inverses_.local(b, c.slice(r, b), zb);
    else
      c.bodies[b]->precondition(first_block_[b], diagonal_, c.slice(r, b), zb);
  });
  if (contacts_ == 0) return;
  const ScopedSeconds contact_timer(contact_seconds());
  if (!plain_) preconditioner_.apply(r, z);
  const ProfileScope scope("coarse modes, applied");
  if (coarse_) modes_.add(r, z);
}

}  // namespace brim
