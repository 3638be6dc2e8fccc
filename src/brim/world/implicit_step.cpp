#include "brim/world/implicit_step.h"

#include <fmt/format.h>

#include <optional>

#include "brim/body/rigid_frame.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/stopwatch.h"

namespace brim {

namespace {

/// Share of the velocities whose change is rounding: where nothing acts, the solve need not resolve it.
constexpr double kNegligible = 1e-11;
/// Tolerance of a solve that another one follows, over that of the last.
constexpr double kDraft = 10.0;
/// Change of the contact forces, over the one that ends the passes, below which the next solve may be the last.
constexpr double kNear = 20.0;
/// Velocities up to which a body's system is one block of its diagonal.
constexpr std::size_t kSmall = 6;
/// Tolerance where the preconditioner is the inverse.
constexpr double kExact = 1e-10;

}  // namespace

bool ImplicitStep::solve_frames(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                                const Environment& env, double dt, std::span<const double> impulse,
                                std::span<double> delta) {
  for (const auto& body : bodies)
    if (dynamic_cast<const RigidFrame*>(body.get()) == nullptr) return false;
  parallel_for(
      bodies.size(),
      [&](std::size_t b) {
        const ProfileScope scope("elements", *bodies[b]);
        using Six = Eigen::Matrix<double, 6, 1>;
        Six force = Six::Zero();
        bodies[b]->begin_solve(dt);
        bodies[b]->add_forces(env, {force.data(), 6});
        force *= dt;
        if (!impulse.empty()) force += Eigen::Map<const Six>(impulse.data() + first_v[b]);
        const RigidFrame::Frame f = dynamic_cast<const RigidFrame&>(*bodies[b]).rigid_frame();
        Eigen::Map<Six> change(delta.data() + first_v[b]);
        change << f.inverse_mass * force.head<3>(), f.inverse_inertia * force.tail<3>();
      },
      64);
  return true;
}

bool ImplicitStep::solve(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                         std::span<const WorldPart> parts, const Environment& env, const ContactMaps& maps,
                         Penalty& response, const ContactSet& contact_set, std::span<const double> v,
                         const Settings& settings, std::span<double> delta, StepReport& report,
                         std::span<const double> impulse, const Correct& correct) {
  const double dt = settings.dt;
  const std::size_t n = v.size();
  // Where constraint rows answer all contacts of small bodies, the system is that of their own blocks.
  bool alone = response.idle();
  for (std::size_t b = 0; b < bodies.size() && alone; ++b) alone = first_v[b + 1] - first_v[b] <= kSmall;
  const std::size_t contacts = alone ? 0 : contact_set.size();
  const ScopedSeconds timer(report.seconds[static_cast<std::size_t>(Phase::Solve)]);
  double& contact_seconds = report.seconds[static_cast<std::size_t>(Phase::SolveContact)];

  // Inner forces: dt (Q + dt ∂Q/∂q v), and the matrices of the bodies.
  internal_.assign(n, 0.0), scratch_.assign(n, 0.0), rhs_.resize(n);
  const auto slice = [&](auto& x, std::size_t b) {
    return std::span(x).subspan(first_v[b], first_v[b + 1] - first_v[b]);
  };
  if (alone && solve_frames(bodies, first_v, env, dt, impulse, delta)) {
    // Each body by its own mass and inertia; what rows do besides is theirs.
    contact_delta_.assign(contact_set.size(), Vec3::Zero());
    ++report.solves;
    const ScopedSeconds rows_timer(contact_seconds);
    return !correct || correct([](std::span<const double>, std::span<double>) { return SolveReport{}; }, delta);
  }
  parallel_for(bodies.size(), [&](std::size_t b) {
    const ProfileScope scope("elements", *bodies[b]);
    bodies[b]->begin_solve(dt);
    bodies[b]->add_forces(env, slice(internal_, b));
    bodies[b]->apply_stiffness(slice(v, b), slice(scratch_, b));
  });
  for (std::size_t i = 0; i < n; ++i)
    internal_[i] = dt * (internal_[i] + dt * scratch_[i]) + (impulse.empty() ? 0.0 : impulse[i]);

  std::vector<int> sizes;
  first_block_.assign(1, 0);
  for (const auto& body : bodies) {
    const std::vector<int> s = body->block_sizes();
    sizes.insert(sizes.end(), s.begin(), s.end());
    first_block_.push_back(sizes.size());
  }
  bodies_diagonal_.reset(sizes);
  parallel_for(bodies.size(),
               [&](std::size_t b) { bodies[b]->add_system_diagonal(first_block_[b], bodies_diagonal_); });

  LinearSystem system;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    system.negligible += kNegligible * kNegligible * 2.0 * bodies[b]->kinetic_energy(slice(v, b));
  system.filter = [&](std::span<double> x) {
    parallel_for(bodies.size(), [&](std::size_t b) { bodies[b]->filter(slice(x, b)); });
  };
  system.apply = [&](std::span<const double> x, std::span<double> y) {
    parallel_for(bodies.size(), [&](std::size_t b) {
      const ProfileScope scope("product", *bodies[b]);
      const auto yb = slice(y, b);
      std::fill(yb.begin(), yb.end(), 0.0);
      bodies[b]->apply_system(slice(x, b), yb);
    });
    if (contacts == 0) return;
    const ScopedSeconds contact_timer(contact_seconds);
    acting_.add_response(
        x, [&](std::size_t c, const Vec3& d) { return response.apply(c, d); }, y);
  };
  if (contacts > 0) {
    const ScopedSeconds contact_timer(contact_seconds);
    sparse_.resize(bodies.size());
    for (std::size_t b = 0; b < bodies.size(); ++b) sparse_[b] = maps.sparse_rows(b);
    factor_.begin(bodies, first_v, bodies_diagonal_, first_block_, sparse_);
  }
  // Where every velocity belongs to a rigid body the factor is the whole system, but for rounding in single precision:
  // one iteration more makes the solution exact.
  const bool whole = contacts > 0 && factor_.knows_all_rigid();
  bool coarse = contacts > 0 && !whole;
  if (coarse) {
    const ScopedSeconds contact_timer(contact_seconds);
    modes_.begin(bodies, first_v, parts, maps, contact_set, factor_.rigid());
  }
  system.precondition = [&](std::span<const double> r, std::span<double> z) {
    parallel_for(bodies.size(), [&](std::size_t b) {
      const ProfileScope scope("precondition", *bodies[b]);
      const auto zb = slice(z, b);
      if (coarse && modes_.complete(b))
        std::fill(zb.begin(), zb.end(), 0.0);
      else
        bodies[b]->precondition(first_block_[b], diagonal_, slice(r, b), zb);
    });
    if (contacts == 0) return;
    const ScopedSeconds contact_timer(contact_seconds);
    factor_.apply(r, z);
    if (coarse) modes_.add(r, z);
  };

  if (contacts > room_) {
    // Memory follows the number of contacts, not which of them act.
    const ScopedSeconds contact_timer(contact_seconds);
    acting_.build(parts, contact_set, first_v);
    acting_.gather_rows(contact_rows_);
    factor_.reserve(contact_rows_);
    room_ = contacts;
  }
  contact_delta_.assign(contact_set.size(), Vec3::Zero()), contact_force_.resize(contacts);
  std::fill(delta.begin(), delta.end(), 0.0);
  const int passes = contacts > 0 ? settings.passes : 1;
  bool settled = false, near = false;
  for (int pass = 0; pass < passes; ++pass) {
    diagonal_ = bodies_diagonal_;
    rhs_ = internal_;
    if (contacts > 0) {
      const ScopedSeconds contact_timer(contact_seconds);
      if (pass == 0 || !acting_.serves(response.acting()))
        acting_.build(parts, contact_set, first_v, maps, response.acting());
      response.right_hand_side(contact_force_);
      for (Vec3& f : contact_force_) f *= dt;
      acting_.add_forces(contact_force_, rhs_);
      acting_.add_block_diagonal([&](std::size_t c) { return response.block(c); }, first_block_, diagonal_);
    }
    parallel_for(bodies.size(), [&](std::size_t b) { bodies[b]->prepare_preconditioner(first_block_[b], diagonal_); });
    diagonal_.factor();
    if (contacts > 0) {
      const ScopedSeconds contact_timer(contact_seconds);
      acting_.gather_rows(contact_rows_);
      for (std::size_t i = 0; i < contact_rows_.size(); ++i)
        contact_rows_.stiffness[i] = response.block(contact_rows_.contact[i]).cast<float>();
      factor_.factor(contact_rows_);
      coarse = !whole && modes_.factor(contact_set, response);
    }
    // What only tells which contacts let go and how friction is loaded is solved less sharply than what is kept.
    const bool kept = settled || pass + 1 == passes;
    const double tolerance = std::min((kept || near ? 1.0 : kDraft) * settings.tolerance, whole ? kExact : 1.0);
    const SolveReport s = cg_.solve(system, rhs_, tolerance, settings.max_iterations, delta);
    report.cg_iterations += s.iterations;
    ++report.solves;
    if (!s.finite) return false;
    if (!s.converged)
      report.warnings.push_back(
          {report.time, "no_convergence",
           fmt::format("the solve stopped after {} iterations at relative residual {:.1e}", s.iterations, s.residual)});
    const ScopedSeconds contact_timer(contact_seconds);
    if (contacts > 0) maps.relative(delta, contact_delta_);
    if (!kept) {
      const double change = response.update_loads(contact_set, contact_delta_);
      settled = change < settings.load_tolerance;
      near = change < kNear * settings.load_tolerance;
    }
    if (kept || (settled && s.residual <= settings.tolerance)) {
      report.cg_residual = std::max(report.cg_residual, s.residual);
      break;
    }
  }
  if (!correct) return true;
  // Rows, their sweeps and the solves that they ask for are there because of contact: all of it counts, once.
  double within = 0.0;
  const double before = contact_seconds;
  auto rows_timer = std::make_optional<ScopedSeconds>(within);
  const bool finite =
      correct([&](std::span<const double> b,
                  std::span<double> x) { return cg_.solve(system, b, settings.tolerance, settings.max_iterations, x); },
              delta);
  if (contacts > 0) maps.relative(delta, contact_delta_);
  rows_timer.reset();
  contact_seconds = before + within;
  return finite;
}

}  // namespace brim
