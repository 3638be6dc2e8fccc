#include "brim/world/implicit_step.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>

#include "brim/body/foresees_contact.h"
#include "brim/core/interface_of.h"
#include "brim/core/profile.h"
#include "brim/core/stopwatch.h"

namespace brim {

namespace {

/// Tolerance of a solve that is followed by another, relative to that of the last.
constexpr double kDraft = 10.0;
/// Change of the contact forces, relative to the tolerance, below which the next solve may be the last.
constexpr double kNear = 20.0;
/// Velocities up to which a body's system is one block of its diagonal.
constexpr std::size_t kSmall = 6;
/// Tolerance when the preconditioner is the inverse.
constexpr double kExact = 1e-10;
/// Rounding error after the pressure is removed, relative to the impulses on fluids and solids in them.
constexpr double kRelieved = 1e-9;
/// Factor on the number of solves then allowed: each releases a third of the nodes that hold a toppling body.
constexpr int kExactPasses = 3;

}  // namespace

bool ImplicitStep::solve(const StepContext& context, const Settings& settings, std::span<double> delta,
                         const Correct& correct) {
  context_ = &context, settings_ = &settings;
  alone_ = context.response.idle();
  for (std::size_t b = 0; b < context.bodies.size() && alone_; ++b)
    alone_ = context.first_v[b + 1] - context.first_v[b] <= kSmall;
  contacts_ = alone_ ? 0 : context.contacts.size();
  contact_delta_.assign(context.contacts.size(), Vec3::Zero());
  const ScopedSeconds timer(context.report.seconds_of(Phase::Solve));
  if (alone_ && solve_frames(delta)) {
    // Each body by its own mass and inertia; the rows act afterwards.
    ++context.report.solves;
    const ScopedSeconds rows_timer(contact_seconds());
    return !correct ||
           correct([](std::span<const double>, std::span<double>, double) { return SolveReport{}; }, delta, {});
  }
  if (!alone_) guide();
  taken_.clear();
  begin_bodies();
  begin_system();
  begin_preconditioner();
  if (!make_passes(delta)) return false;
  if (!correct) {
    give_back(delta);
    return true;
  }
  if (!correct_by(correct, delta)) return false;
  if (added_.empty()) return true;
  // What rows stop may be met by what came along with it; what they set going may leave a limit that held it.
  taken_ = added_;
  const bool freed = contacts_ > 0 && context.response.release_stops(contact_delta_);
  return (!foresee(delta) && !freed) || (make_passes(delta) && correct_by(correct, delta));
}

bool ImplicitStep::make_passes(std::span<double> delta) {
  const StepContext& c = *context_;
  contact_force_.resize(contacts_);
  std::fill(delta.begin(), delta.end(), 0.0);
  const int passes = contacts_ > 0 ? (whole_ ? kExactPasses * settings_->passes : settings_->passes) : 1;
  settled_ = contacts_ > 0 && c.response.settled() && !c.follow_arcs;
  bool near = false;
  scale_.clear(), iterations_made_ = 0;
  for (int pass = 0; pass < passes; ++pass) {
    find_right_hand_side(pass == 0);
    if (contacts_ == 0 && c.coupling.empty()) {
      // Free bodies fall and turn as a whole, however stiff they are.
      residual_ = rhs_;
      give_back(delta);
    }
    // Solves that only determine released contacts and friction loads are less accurate than the one that is kept.
    const bool kept = settled_ || pass + 1 == passes;
    const SolveReport s = solve_once(pass, kept, near, delta);
    if (!s.finite) return false;
    const ScopedSeconds contact_timer(contact_seconds());
    if (contacts_ > 0) c.maps.relative(delta, contact_delta_);
    if (contacts_ > 0) c.fill.finish(c.first_v, delta, contact_delta_);
    if (!kept) {
      c.response.keep_loads();
      c.fill.give_loads(c.response);
      const double change = c.response.update_loads(c.contacts, contact_delta_);
      settled_ = change < settings_->load_tolerance;
      near = change < kNear * settings_->load_tolerance;
      if (foresee(delta)) settled_ = near = false;
      if (c.follow_arcs) {
        const double arcs = c.follow_arcs(delta, contact_delta_);
        settled_ = settled_ && arcs <= 1.0, near = near && arcs <= kNear;
      }
    }
    if (kept || (settled_ && s.residual <= settings_->tolerance)) {
      c.report.cg_residual = std::max(c.report.cg_residual, s.residual);
      if (!kept) c.response.take_back_loads();
      break;
    }
  }
  // The reported forces are those of the solve; the bodies' missing momenta are given back afterwards.
  if (c.coupling.empty()) {
    residual_.assign(cg_.residual().begin(), cg_.residual().end());
  } else {
    find_residual(delta, {});
  }
  return true;
}

bool ImplicitStep::foresee(std::span<const double> delta) {
  const StepContext& c = *context_;
  bool changed = false;
  for (std::size_t b = 0; b < c.bodies.size(); ++b) {
    auto* body = interface_of<ForeseesContact>(*c.bodies[b]);
    if (body == nullptr || unmoved(b)) continue;
    const auto v = c.slice(c.v, b), d = c.slice(delta, b);
    after_.assign(v.begin(), v.end());
    for (std::size_t i = 0; i < after_.size(); ++i) after_[i] += d[i];
    changed = body->foresee(after_) || changed;
  }
  if (!changed) return false;
  // Coarse modes are rigid motions, of which inner contacts know nothing.
  gather_bodies();
  begin_contact_preconditioner();
  return true;
}

void ImplicitStep::find_residual(std::span<const double> delta, std::span<const double> added) {
  system_.apply(delta, scratch_);
  residual_.resize(delta.size());
  for (std::size_t i = 0; i < delta.size(); ++i)
    residual_[i] = rhs_[i] + (added.empty() ? 0.0 : added[i]) - scratch_[i];
  system_.filter(residual_);
  FluidCoupling& coupling = context_->coupling;
  if (!coupling.empty()) coupling.finish(invert_, residual_);
}

void ImplicitStep::find_right_hand_side(bool first) {
  const StepContext& c = *context_;
  rhs_ = internal_;
  if (contacts_ == 0) return;
  const ScopedSeconds contact_timer(contact_seconds());
  if (first || !acting_.serves(c.response.acting()))
    acting_.build(c.parts, c.contacts, c.first_v, c.maps, c.response.acting());
  c.response.right_hand_side(contact_force_);
  c.fill.add_right_hand_side(contact_force_);
  for (Vec3& f : contact_force_) f *= settings_->dt;
  acting_.add_forces(contact_force_, rhs_);
}

SolveReport ImplicitStep::solve_once(int pass, bool kept, bool near, std::span<double> delta) {
  StepReport& report = context_->report;
  // The preconditioner stays good when loads have settled or only few contacts change; the inverse of a rigid system
  // must be exact.
  const bool held = !fresh_ && !whole_ && (settled_ || preconditioner_.serves(context_->response));
  if (!held) prepare();
  FluidCoupling& coupling = context_->coupling;
  if (pass == 0 && !coupling.empty()) {
    flowing_.assign(delta.size(), 0.0);
    coupling.keep_volume(invert_, context_->v, flowing_);
    std::copy(flowing_.begin(), flowing_.end(), delta.begin());
  }
  const double tolerance = std::min((kept || near ? 1.0 : kDraft) * settings_->tolerance, whole_ ? kExact : 1.0);
  const auto solve_in = [&](int most) {
    SolveReport r;
    if (coupling.empty()) {
      r = cg_.solve(system_, rhs_, tolerance, most, delta, scale_);
    } else {
      // A Δ' = b − A Δ₀ among volume-conserving velocities, Δ = Δ₀ + Δ'.
      shifted_.resize(rhs_.size());
      system_.apply(flowing_, shifted_);
      for (std::size_t i = 0; i < rhs_.size(); ++i) shifted_[i] = rhs_[i] - shifted_[i], delta[i] -= flowing_[i];
      ignore_of_relieved();
      coupling.relieve(invert_, shifted_);
      r = cg_.solve(system_, shifted_, tolerance, most, delta, scale_);
      for (std::size_t i = 0; i < rhs_.size(); ++i) delta[i] += flowing_[i];
    }
    report.cg_iterations += r.iterations;
    return r;
  };
  int most = settings_->max_iterations;
  if (held && !settled_) most = std::min(most, ContactPreconditioner::patience(iterations_made_));
  SolveReport s = solve_in(most);
  if (!s.finite && contacts_ > 0 && !plain_) {
    // Where too many pivots of a factor had to be raised, it grows beyond single precision.
    plain_ = true;
    std::fill(delta.begin(), delta.end(), 0.0);
    if (!coupling.empty()) std::copy(flowing_.begin(), flowing_.end(), delta.begin());
    s = solve_in(settings_->max_iterations);
  }
  if (s.finite && !s.converged && most < settings_->max_iterations) prepare(), s = solve_in(settings_->max_iterations);
  if (s.finite && !coupling.empty()) coupling.keep_volume(invert_, context_->v, delta);
  if (!held) iterations_made_ = s.iterations;
  ++report.solves;
  if (s.finite && !s.converged)
    report.warnings.push_back(
        {report.time, "no_convergence",
         fmt::format("the solve stopped after {} iterations at relative residual {:.1e}", s.iterations, s.residual)});
  return s;
}

void ImplicitStep::ignore_of_relieved() {
  answer_.resize(shifted_.size());
  invert_(shifted_, answer_, FluidCoupling::Of::All);
  std::vector<double> energy(negligible_.size(), 0.0);
  for (std::size_t b = 0; b < context_->bodies.size(); ++b) {
    const auto r = context_->slice(shifted_, b);
    const auto z = context_->slice(answer_, b);
    for (std::size_t i = 0; i < r.size(); ++i) energy[island_[b]] += r[i] * z[i];
  }
  for (std::size_t k = 0; k < energy.size(); ++k)
    negligible_[k] = std::max(negligible_[k], kRelieved * kRelieved * energy[k]);
}

void ImplicitStep::give_back(std::span<double> delta) {
  if (alone_) return;
  const StepContext& c = *context_;
  if (!whole_) modes_.give_back(residual_, delta);
  c.coupling.give_back(residual_, delta);
  for (std::size_t b = 0; b < c.bodies.size(); ++b) {
    if (lone_[b] == 0 || c.bodies[b]->immobile() || unmoved(b)) continue;
    const auto size = static_cast<Eigen::Index>(c.first_v[b + 1] - c.first_v[b]);
    Eigen::Map<Eigen::VectorXd>(delta.data() + c.first_v[b], size) +=
        bodies_diagonal_.block(first_block_[b])
            .ldlt()
            .solve(Eigen::Map<const Eigen::VectorXd>(residual_.data() + c.first_v[b], size));
  }
}

bool ImplicitStep::correct_by(const Correct& correct, std::span<double> delta) {
  const StepContext& c = *context_;
  // Rows, their sweeps and their solves exist because of contact: all their time counts as contact, once.
  double within = 0.0;
  const double before = contact_seconds();
  auto rows_timer = std::make_optional<ScopedSeconds>(within);
  const std::size_t n = c.v.size();
  const bool foresees =
      std::ranges::any_of(c.bodies, [](const auto& body) { return interface_of<ForeseesContact>(*body) != nullptr; });
  added_.assign(foresees || !((whole_ && !c.response.has_stops()) || alone_) ? n : 0, 0.0);
  const auto respond = [&](std::span<const double> b, std::span<double> x, double slack) {
    return cg_.solve(system_, b, slack * settings_->tolerance, settings_->max_iterations, x);
  };
  const bool finite = correct(respond, delta, added_);
  if (finite && !c.coupling.empty()) c.coupling.keep_volume(invert_, c.v, delta);
  if (contacts_ > 0) c.maps.relative(delta, contact_delta_), c.fill.finish(c.first_v, delta, contact_delta_);
  if (!added_.empty()) {
    // Rows are then exact up to the residual of the solve: a velocity of the size of its tolerance.
    find_residual(delta, added_);
    give_back(delta);
  }
  rows_timer.reset();
  contact_seconds() = before + within;
  return finite;
}

}  // namespace brim
