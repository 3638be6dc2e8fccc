#include "brim/world/implicit_step.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <functional>
#include <optional>

#include "brim/body/guided_particles.h"
#include "brim/body/rigid_frame.h"
#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/stopwatch.h"
#include "brim/world/islands.h"

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
/// Times as many solves may be made there: each lets go of a third of the nodes that hold a body that tips over.
constexpr int kExactPasses = 3;
/// Tolerance of an island with links, over the usual one: rigid ones rule the residual, and what it leaves of softer
/// motions would shake them.
constexpr double kLinked = 1e-2;
/// Overlap above which what lies on something fixed is guided by it: rows hold it at the brink.
constexpr float kGuided = -0.1f;

}  // namespace

bool ImplicitStep::solve_frames(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                                const Environment& env, const Settings& settings, std::span<const double> impulse,
                                std::span<double> delta) {
  const double dt = settings.dt;
  for (const auto& body : bodies)
    if (body->v_size() > 0 && dynamic_cast<const RigidFrame*>(body.get()) == nullptr) return false;
  parallel_for(
      bodies.size(),
      [&](std::size_t b) {
        if (first_v[b + 1] == first_v[b]) return;  // space
        const ProfileScope scope("elements", *bodies[b]);
        using Six = Eigen::Matrix<double, 6, 1>;
        Eigen::Map<Six> change(delta.data() + first_v[b]);
        change.setZero();
        if (!settings.asleep.empty() && settings.asleep[b]) return;
        Six force = Six::Zero();
        bodies[b]->begin_solve(dt);
        bodies[b]->add_forces(settings.environment(b, env), {force.data(), 6});
        force *= dt;
        if (!impulse.empty()) force += Eigen::Map<const Six>(impulse.data() + first_v[b]);
        const RigidFrame::Frame f = dynamic_cast<const RigidFrame&>(*bodies[b]).rigid_frame();
        change << f.inverse_mass * force.head<3>(), f.inverse_inertia * force.tail<3>();
      },
      64);
  return true;
}

bool ImplicitStep::solve(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                         std::span<const WorldPart> parts, const Environment& env, const ContactMaps& maps,
                         Penalty& response, const ContactSet& contact_set, std::span<const double> v,
                         const Settings& settings, std::span<double> delta, StepReport& report, FillStage& fill,
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
  const auto asleep = [&](std::size_t b) { return !settings.asleep.empty() && settings.asleep[b]; };
  if (alone && solve_frames(bodies, first_v, env, settings, impulse, delta)) {
    // Each body by its own mass and inertia; what rows do besides is theirs.
    contact_delta_.assign(contact_set.size(), Vec3::Zero());
    ++report.solves;
    const ScopedSeconds rows_timer(contact_seconds);
    return !correct || correct([](std::span<const double>, std::span<double>) { return SolveReport{}; }, delta, {});
  }
  if (!alone) guide(bodies, first_v, maps, response, contact_set);
  parallel_for(bodies.size(), [&](std::size_t b) {
    if (asleep(b)) return;
    const ProfileScope scope("elements", *bodies[b]);
    bodies[b]->begin_solve(dt);
    bodies[b]->add_forces(settings.environment(b, env), slice(internal_, b));
    if (fill.handles(b))
      fill.add_start_stiffness(b, slice(scratch_, b));
    else if (const auto* guided = dynamic_cast<const GuidedParticles*>(bodies[b].get()))
      guided->apply_start_stiffness(slice(v, b), slice(scratch_, b));
    else
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
  parallel_for(bodies.size(), [&](std::size_t b) {
    if (!asleep(b)) bodies[b]->add_system_diagonal(first_block_[b], bodies_diagonal_);
  });

  LinearSystem system;
  find_islands(bodies, parts, contact_set, settings);
  negligible_.assign(sharpness_.size(), 0.0);
  for (std::size_t b = 0; b < bodies.size(); ++b)
    negligible_[island_[b]] += kNegligible * kNegligible * 2.0 * bodies[b]->kinetic_energy(slice(v, b));
  system.first = first_v, system.island = island_, system.negligible = negligible_;
  system.sharpness = sharpness_;
  system.filter = [&](std::span<double> x) {
    parallel_for(bodies.size(), [&](std::size_t b) {
      const auto xb = slice(x, b);
      if (asleep(b))
        std::fill(xb.begin(), xb.end(), 0.0);
      else
        bodies[b]->filter(xb);
    });
  };
  system.apply = [&](std::span<const double> x, std::span<double> y) {
    if (contacts > 0) {
      const ScopedSeconds contact_timer(contact_seconds);
      acting_.take_velocities(x);
      if (!fill.empty())
        acting_.for_taken(fill.first(), [&](std::size_t c, const Vec3& d) {
          if (fill.holds(c)) fill.see(c, d);
        });
    }
    parallel_for(bodies.size(), [&](std::size_t b) {
      const ProfileScope scope("product", *bodies[b]);
      const auto yb = slice(y, b);
      std::fill(yb.begin(), yb.end(), 0.0);
      if (asleep(b) || cg_.solved(b)) return;
      if (fill.handles(b))
        fill.apply_system(b, slice(x, b), yb);
      else
        bodies[b]->apply_system(slice(x, b), yb);
    });
    if (contacts == 0) return;
    const ScopedSeconds contact_timer(contact_seconds);
    const ProfileScope scope("contact product");
    acting_.answer(
        [&](std::size_t c, const Vec3& d) {
          return fill.holds(c) ? Vec3(response.apply(c, d) - fill.impulse(c)) : response.apply(c, d);
        },
        y);
  };
  if (contacts > 0) {
    const ScopedSeconds contact_timer(contact_seconds);
    sparse_.resize(bodies.size());
    for (std::size_t b = 0; b < bodies.size(); ++b) sparse_[b] = maps.sparse_rows(b);
    preconditioner_.begin(bodies, first_v, bodies_diagonal_, first_block_, sparse_, island_, settings.asleep);
  }
  // Where every velocity belongs to a rigid body the factor is the whole system, but for rounding in single precision:
  // one iteration more makes the solution exact.
  const bool whole = contacts > 0 && preconditioner_.knows_all_rigid();
  bool coarse = contacts > 0 && !whole;
  lone_.resize(bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b)
    lone_[b] = contacts > 0
                   ? preconditioner_.rigid()[b]
                   : first_block_[b + 1] == first_block_[b] + 1 && bodies_diagonal_.block_size(first_block_[b]) == 6;
  if (!whole && !alone) {
    const auto contact_timer =
        contacts > 0 ? std::make_optional<ScopedSeconds>(contact_seconds) : std::optional<ScopedSeconds>();
    const ProfileScope scope("coarse modes, made");
    without_ = lone_;
    for (std::size_t b = 0; b < bodies.size(); ++b) without_[b] |= asleep(b);
    modes_.begin(bodies, first_v, parts, without_);
  }
  system.precondition = [&](std::span<const double> r, std::span<double> z) {
    parallel_for(bodies.size(), [&](std::size_t b) {
      const ProfileScope scope("precondition", *bodies[b]);
      const auto zb = slice(z, b);
      if (cg_.solved(b)) return;
      if (asleep(b) || (coarse && modes_.complete(b)))
        std::fill(zb.begin(), zb.end(), 0.0);
      else
        bodies[b]->precondition(first_block_[b], diagonal_, slice(r, b), zb);
    });
    if (contacts == 0) return;
    const ScopedSeconds contact_timer(contact_seconds);
    preconditioner_.apply(r, z);
    const ProfileScope scope("coarse modes, applied");
    if (coarse) modes_.add(r, z);
  };

  if (contacts > room_) {
    // Memory follows the number of contacts, not which of them act.
    const ScopedSeconds contact_timer(contact_seconds);
    acting_.build(parts, contact_set, first_v);
    preconditioner_.reserve(acting_);
    room_ = contacts;
  }
  contact_delta_.assign(contact_set.size(), Vec3::Zero()), contact_force_.resize(contacts);
  std::fill(delta.begin(), delta.end(), 0.0);
  const int passes = contacts > 0 ? (whole ? kExactPasses * settings.passes : settings.passes) : 1;
  bool settled = contacts > 0 && response.settled(), near = false;
  std::vector<double> scale;  // of the first pass, for all
  int iterations_made = 0;    // of the last solve for which the preconditioner was made
  for (int pass = 0; pass < passes; ++pass) {
    rhs_ = internal_;
    if (contacts > 0) {
      const ScopedSeconds contact_timer(contact_seconds);
      if (pass == 0 || !acting_.serves(response.acting()))
        acting_.build(parts, contact_set, first_v, maps, response.acting());
      response.right_hand_side(contact_force_);
      fill.add_right_hand_side(contact_force_);
      for (Vec3& f : contact_force_) f *= dt;
      acting_.add_forces(contact_force_, rhs_);
    }
    const auto prepare = [&] {
      diagonal_ = bodies_diagonal_;
      if (contacts > 0) {
        const ScopedSeconds contact_timer(contact_seconds);
        acting_.add_block_diagonal([&](std::size_t c) { return response.block(c); }, first_block_, diagonal_);
      }
      parallel_for(bodies.size(), [&](std::size_t b) {
        if (!asleep(b)) bodies[b]->prepare_preconditioner(first_block_[b], diagonal_);
      });
      diagonal_.factor();
      if (contacts > 0) {
        const ScopedSeconds contact_timer(contact_seconds);
        coarse = false;
        const auto beside = [&] {
          const ProfileScope scope("coarse modes, factored");
          coarse = modes_.factor(maps, contact_set, response);
        };
        preconditioner_.make(acting_, response, pass == 0, whole ? std::function<void()>() : beside);
      }
    };
    // Loads that have settled leave the preconditioner as good as it was, and so do few contacts that change; the
    // inverse of a rigid system must be exact.
    const bool held = pass > 0 && !whole && (settled || preconditioner_.serves(response));
    if (!held) prepare();
    // What only tells which contacts let go and how friction is loaded is solved less sharply than what is kept.
    const bool kept = settled || pass + 1 == passes;
    const double tolerance = std::min((kept || near ? 1.0 : kDraft) * settings.tolerance, whole ? kExact : 1.0);
    const auto solve_it = [&](int most) {
      const SolveReport r = cg_.solve(system, rhs_, tolerance, most, delta, scale);
      report.cg_iterations += r.iterations;
      return r;
    };
    int most = settings.max_iterations;
    if (held && !settled) most = std::min(most, ContactPreconditioner::patience(iterations_made));
    SolveReport s = solve_it(most);
    if (s.finite && !s.converged && most < settings.max_iterations) prepare(), s = solve_it(settings.max_iterations);
    if (!held) iterations_made = s.iterations;
    ++report.solves;
    if (!s.finite) return false;
    if (!s.converged)
      report.warnings.push_back(
          {report.time, "no_convergence",
           fmt::format("the solve stopped after {} iterations at relative residual {:.1e}", s.iterations, s.residual)});
    const ScopedSeconds contact_timer(contact_seconds);
    if (contacts > 0) maps.relative(delta, contact_delta_);
    if (contacts > 0) fill.finish(first_v, delta, contact_delta_);
    if (!kept) {
      response.keep_loads();
      fill.give_loads(response);
      const double change = response.update_loads(contact_set, contact_delta_);
      settled = change < settings.load_tolerance;
      near = change < kNear * settings.load_tolerance;
    }
    if (kept || (settled && s.residual <= settings.tolerance)) {
      report.cg_residual = std::max(report.cg_residual, s.residual);
      if (!kept) response.take_back_loads();
      break;
    }
  }
  // The forces that are told are those of the solve; what it left of the bodies' momenta follows.
  residual_.assign(cg_.residual().begin(), cg_.residual().end());
  const auto size = [&](std::size_t b) { return static_cast<Eigen::Index>(first_v[b + 1] - first_v[b]); };
  const auto give_back = [&] {
    if (whole || alone) return;
    modes_.give_back(residual_, delta);
    for (std::size_t b = 0; b < bodies.size(); ++b)
      if (lone_[b] && !bodies[b]->immobile() && !asleep(b))
        Eigen::Map<Eigen::VectorXd>(delta.data() + first_v[b], size(b)) +=
            bodies_diagonal_.block(first_block_[b])
                .ldlt()
                .solve(Eigen::Map<const Eigen::VectorXd>(residual_.data() + first_v[b], size(b)));
  };
  if (!correct) {
    give_back();
    return true;
  }
  // Rows, their sweeps and the solves that they ask for are there because of contact: all of it counts, once.
  double within = 0.0;
  const double before = contact_seconds;
  auto rows_timer = std::make_optional<ScopedSeconds>(within);
  added_.assign(whole || alone ? 0 : n, 0.0);
  const bool finite =
      correct([&](std::span<const double> b,
                  std::span<double> x) { return cg_.solve(system, b, settings.tolerance, settings.max_iterations, x); },
              delta, added_);
  if (contacts > 0) maps.relative(delta, contact_delta_), fill.finish(first_v, delta, contact_delta_);
  if (!added_.empty()) {
    // Rows then hold to what the solve left: a velocity of the size of its tolerance.
    system.apply(delta, scratch_);
    for (std::size_t i = 0; i < n; ++i) residual_[i] = rhs_[i] + added_[i] - scratch_[i];
    system.filter(residual_);
    give_back();
  }
  rows_timer.reset();
  contact_seconds = before + within;
  return finite;
}

void ImplicitStep::find_islands(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
                                const ContactSet& contact_set, const Settings& settings) {
  Islands islands(bodies.size());
  const auto moves = [&](const WorldPart& p) {
    return !is_fixed(p) && (settings.asleep.empty() || !settings.asleep[static_cast<std::size_t>(p.body_index)]);
  };
  for (const ContactPair& pair : contact_set.pairs)
    if (moves(parts[pair.part_a]) && moves(parts[pair.part_b]))
      islands.join(parts[pair.part_a].body_index, parts[pair.part_b].body_index);
  island_ = islands.numbers();
  sharpness_.assign(island_.empty() ? 0 : 1 + static_cast<std::size_t>(*std::ranges::max_element(island_)), 1.0);
  for (std::size_t p = contact_set.first_link_pair(); p < contact_set.pairs.size(); ++p)
    for (const int part : {contact_set.pairs[p].part_a, contact_set.pairs[p].part_b})
      sharpness_[island_[parts[part].body_index]] = kLinked;
}

void ImplicitStep::guide(std::span<const std::unique_ptr<Body>> bodies, std::span<const std::size_t> first_v,
                         const ContactMaps& maps, const Penalty& response, const ContactSet& contact_set) {
  // Particles that a force at one of these contacts would reach.
  contact_force_.assign(contact_set.size(), Vec3::Zero());
  bool any = false;
  for (std::size_t p = 0; p < contact_set.pairs.size(); ++p) {
    const ContactPair& pair = contact_set.pairs[p];
    for (std::size_t c = pair.begin; c < pair.end && response.guides(p); ++c)
      if (contact_set.overlap[c] > kGuided) contact_force_[c] = Vec3::Ones(), any = true;
  }
  if (!any) return;
  scratch_.assign(first_v.back(), 0.0);
  maps.add_forces(contact_force_, scratch_);
  std::vector<std::uint8_t> guided;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    auto* body = dynamic_cast<GuidedParticles*>(bodies[b].get());
    if (body == nullptr) continue;
    guided.assign((first_v[b + 1] - first_v[b]) / 3, 0);
    bool touched = false;
    for (std::size_t i = 0; i < guided.size(); ++i)
      if (scratch_[first_v[b] + 3 * i] != 0.0) guided[i] = 1, touched = true;
    if (touched) body->set_guided(guided);
  }
  std::fill(scratch_.begin(), scratch_.end(), 0.0);
}

}  // namespace brim
