#include "brim/response/penalty.h"

#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"
#include "brim/core/workspace_pool.h"
#include "brim/response/fitting_solids.h"
#include "brim/response/moved_rows.h"
#include "brim/response/patch_normals.h"

namespace brim {

namespace {

/// Curvature times h below which a surface counts as flat: the stencil gives up to 0.005 on tilted planes.
constexpr double kCurvatureOfNoise = 0.005;
/// [h] way over which a solid's direction is asked, and cosine of how much it may turn, where it is even.
constexpr double kEvenWay = 0.5, kEvenCosine = 0.999;

double weight_of(const ContactSet& contacts, std::size_t c) { return PatchNormals::weight_of(contacts, c); }

/// Frobenius norm of a packed tensor (unpack_tangent_tensor).
double size_of(const std::array<float, 3>& t) {
  return std::sqrt(double{t[0]} * t[0] + 2.0 * (double{t[1]} * t[1]) + double{t[2]} * t[2]);
}

}  // namespace

struct Penalty::Workspaces : WorkspacePool<PatchNormals> {};

Penalty::Penalty() : workspaces_(std::make_unique<Workspaces>()) {}
Penalty::~Penalty() = default;

void Penalty::find_normals(const ContactSet& contacts, std::span<const PairState> pairs) {
  direction_.resize(contacts.size()), normal_.resize(contacts.size());
  patches_.assign(contacts.pairs.size(), {});
  choose_normals(contacts, pairs);
  normals_found_ = true;
}

void Penalty::begin(const ContactSet& contacts, std::span<const PairState> pairs, const PenaltyOptions& options,
                    std::span<const Vec3> velocity_a, std::span<const Vec3> velocity_b) {
  options_ = options;
  pairs_.assign(pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(contacts.pairs.size()));
  const std::size_t n = contacts.size();
  force_.resize(n), relative_.resize(n);
  implicit_time_.resize(n), load_.resize(n), active_.resize(n), rate_.resize(n), stiffness_.resize(n), scale_.resize(n),
      friction_viscosity_.resize(n), mu_.resize(n);
  pressed_.assign(n, 0.0), drag_.assign(n, 0.0);
  bonds_.clear();

  if (!normals_found_) find_normals(contacts, pairs);
  normals_found_ = false;
  patches_.resize(contacts.pairs.size());  // links may have come after their normals were found
  for (std::size_t p = 0; p < patches_.size(); ++p) patches_[p].hardening = Hardening(pairs_[p].growth);
  start_forces(contacts, velocity_a, velocity_b);
  advect_rates(contacts, velocity_a, velocity_b);
  start_friction(contacts);
  settle_actions();

  idle_ = std::none_of(pairs.begin(), pairs.end(), [](const PairState& p) { return p.stiffness > 0.0 || p.filled; });
  settled_ = std::all_of(pairs.begin(), pairs.end(), [](const PairState& p) { return p.filled && p.friction == 0.0; });
  energy_ = overlap_energy(contacts);
}

void Penalty::start_forces(const ContactSet& contacts, std::span<const Vec3> velocity_a,
                           std::span<const Vec3> velocity_b) {
  parallel_for(contacts.pairs.size(), [&](std::size_t p) {
    const ContactPair& pair = contacts.pairs[p];
    const double kv = pairs_[p].stiffness * pair.h * pair.h * pair.h;
    const Hardening& hardening = patches_[p].hardening;
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      const double along = std::max(0.0, direction_[c].dot(normal_[c]));
      // Along the normal only: a force that the stiffness below does not resist would accelerate light bodies
      // violently.
      const Hardening::Line line = hardening.at(contacts.overlap[c]);
      const double kc = kv * line.stiffness;
      force_[c] = (kc * line.offset * along) * normal_[c];
      relative_[c] = velocity_a[c] - velocity_b[c];
      scale_[c] = kc * along;
      stiffness_[c] = kc * along * along;
      implicit_time_[c] = options_.dt + (contacts.overlap[c] > 0.0 ? options_.damping : 0.0);
      mu_[c] = pairs_[p].friction;
    }
  });
}

double Penalty::overlap_energy(const ContactSet& contacts) const {
  double energy = 0.0;
  for (std::size_t p = 0; p < contacts.pairs.size(); ++p) {
    const ContactPair& pair = contacts.pairs[p];
    const double kv = pairs_[p].stiffness * pair.h * pair.h * pair.h;
    for (std::size_t c = pair.begin; c < pair.end; ++c)
      if (contacts.overlap[c] > 0.0) energy += kv * patches_[p].hardening.energy(contacts.overlap[c]);
  }
  return energy;
}

void Penalty::take_normals_of(bool side_b, const ContactSet& contacts, const ContactPair& pair) {
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    direction_[c] = side_b ? Vec3(-contacts.gradient_b[c]) : contacts.gradient_a[c];
    const double length = direction_[c].norm();
    normal_[c] = length > 0.0 ? Vec3(direction_[c] / length) : Vec3::UnitZ();
  }
}

void Penalty::take_exact_normals(const CubeSide& solid, bool is_b, const ContactSet& contacts, const ContactPair& pair,
                                 bool everywhere) {
  const ConvexDistance& distance = *solid.solid->convex();
  const auto away_at = [&](const Vec3& x) {
    Vec3 away;
    distance.distance_and_gradient(solid.pose.to_local(x), away);
    return Vec3(solid.pose.rotation * away);
  };
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const Vec3& x = contacts.point[c];
    const Vec3 away = away_at(x);
    if (away.isZero(0.0)) continue;
    if (!everywhere) {
      const Eigen::Matrix<double, 3, 2> across = kEvenWay * pair.h * tangents_of(away);
      const auto turns = [&](const Vec3& way) { return away.dot(away_at(x + way)) < kEvenCosine; };
      if (turns(across.col(0)) || turns(across.col(1)) || turns(-across.col(0)) || turns(-across.col(1))) continue;
    }
    normal_[c] = is_b ? away : Vec3(-away);
    direction_[c] = (is_b ? contacts.gradient_b[c] : contacts.gradient_a[c]).norm() * normal_[c];
  }
}

void Penalty::choose_normals(const ContactSet& contacts, std::span<const PairState> pairs) {
  parallel_for(contacts.pairs.size(), [&](std::size_t p) {
    const ContactPair& pair = contacts.pairs[p];
    if (pair.begin == pair.end) return;
    const auto [conforming_a, conforming_b] = pairs[p].conforming;
    if (conforming_a != conforming_b) {
      take_normals_of(conforming_a, contacts, pair);
      patches_[p].bend = {0.0, 0.0};
      return;
    }
    patches_[p].fits = pairs[p].rigid && pairs[p].stiffness > 0.0 && pairs[p].solids[0] != nullptr &&
                       pairs[p].solids[1] != nullptr && fit_each_other(contacts, pair);
    const bool brink = !pairs[p].rigid && (pairs[p].stiffness == 0.0 || pairs[p].firm);
    workspaces_->borrow()->find(contacts, pair, direction_, normal_, pairs[p].firm, brink);
    if (const auto& [a, b] = pairs[p].solids; (pairs[p].sheet || pairs[p].balls) && (a != nullptr) != (b != nullptr))
      take_exact_normals(a != nullptr ? *a : *b, b != nullptr, contacts, pair, pairs[p].balls);
    for (std::size_t c = pair.begin; c < pair.end && patches_[p].fits; ++c)
      if (const double length = direction_[c].norm(); length > 0.0) normal_[c] = direction_[c] / length;
    bend_of_patch(contacts, pair, p);
  });
}

void Penalty::bend_of_patch(const ContactSet& contacts, const ContactPair& pair, std::size_t p) {
  double sum = 0.0, flat_a = 0.0, flat_b = 0.0;
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const double weight = weight_of(contacts, c);
    const double slope = 0.5 * (contacts.gradient_a[c] - contacts.gradient_b[c]).norm() / pair.h;
    if (!(slope > 0.0)) continue;
    sum += weight;
    flat_a += weight / (size_of(contacts.bend_a[c]) / slope + 1e-6);
    flat_b += weight / (size_of(contacts.bend_b[c]) / slope + 1e-6);
  }
  const auto bend = [sum](double flat) {
    const double curvature = flat > 0.0 ? sum / flat : 0.0;  // times h
    return curvature / (curvature + kCurvatureOfNoise);
  };
  patches_[p].bend = {bend(flat_a), bend(flat_b)};
}

void Penalty::advect_rates(const ContactSet& contacts, std::span<const Vec3> velocity_a,
                           std::span<const Vec3> velocity_b) {
  parallel_for(contacts.pairs.size(), [&](std::size_t p) { advect_rates_of(p, contacts, velocity_a, velocity_b); });
}

Penalty::Slopes Penalty::slopes_at(std::size_t c, std::size_t p, const ContactSet& contacts) const {
  const auto bend = patches_[p].bend;
  Slopes s;
  s.common = std::max(0.0, direction_[c].dot(normal_[c])) * normal_[c];
  s.a = bend[0] * (contacts.gradient_a[c] - s.common);
  s.b = bend[1] * (contacts.gradient_b[c] + s.common);
  // At an edge a part's own slope is less than the common one, and grows as the other part comes: the predicted
  // rate of closing would be too small.
  if (!pairs_[p].rigid && !pairs_[p].balls)
    s.a -= normal_[c] * normal_[c].dot(s.a), s.b -= normal_[c] * normal_[c].dot(s.b);
  return s;
}

void Penalty::advect_rates_of(std::size_t p, const ContactSet& contacts, std::span<const Vec3> velocity_a,
                              std::span<const Vec3> velocity_b) {
  const ContactPair& pair = contacts.pairs[p];
  const PairState& state = pairs_[p];
  const std::size_t count = pair.end - pair.begin;
  if (count == 0) return;
  const auto rates = std::span(rate_).subspan(pair.begin, count);
  if (state.stiffness == 0.0) {  // held by constraints: the rate affects no force
    std::fill(rates.begin(), rates.end(), 0.0);
    return;
  }
  // The patch may move along the surface: with part b, with part a, or in between.
  Vec3 n = Vec3::Zero();
  for (std::size_t c = pair.begin; c < pair.end; ++c) n += weight_of(contacts, c) * normal_[c];
  n.normalize();
  const Vec3 mean_b = state.mean_velocity_b;
  Vec3 travel = state.mean_velocity_a - mean_b;
  travel -= n * n.dot(travel);

  // Rate = ĝ_n·(v_a − v_b) + e_a·(v_a − c) + e_b·(v_b − c): e is the curved part's own slope minus the common
  // direction, c = mean_b + share * travel the velocity of the patch, by least squares of the whole rate.
  double explained = 0.0, possible = 0.0;
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const auto [g, ea, eb] = slopes_at(c, p, contacts);
    rate_[c] = g.dot(velocity_a[c] - velocity_b[c]) + ea.dot(velocity_a[c] - mean_b) + eb.dot(velocity_b[c] - mean_b);
    const double moved = (ea + eb).dot(travel);
    explained += rate_[c] * moved;
    possible += moved * moved;
  }
  const double share = possible > 0.0 ? std::clamp(explained / possible, 0.0, 1.0) : 0.0;
  if (patches_[p].fits) {
    const auto motion = [&](std::span<const Vec3> velocity, const Vec3& mean) {
      return rigid_motion_of(std::span(contacts.point).subspan(pair.begin, count), velocity.subspan(pair.begin, count),
                             mean);
    };
    return set_rates_by_motion(contacts, pair, *state.solids[0], *state.solids[1],
                               motion(velocity_a, state.mean_velocity_a), motion(velocity_b, mean_b),
                               mean_b + share * travel, options_.dt, rates);
  }
  for (std::size_t c = pair.begin; c < pair.end; ++c) {
    const auto [g, ea, eb] = slopes_at(c, p, contacts);
    // Between zero and the common rate: the implicit damping then leaves a fraction of the velocity between 0 and 1,
    // and cannot add energy at any node. Between rigid parts only the sum over the patch acts, and its scatter must
    // stay symmetric about zero: one-sided clipping would brake rolling.
    const double common = g.dot(velocity_a[c] - velocity_b[c]);
    const double most = std::abs(common), least = state.rigid ? -most : 0.0;
    const double travelling = rate_[c] - share * (ea + eb).dot(travel);
    rate_[c] = common < 0.0 ? std::clamp(travelling, -most, -least) : std::clamp(travelling, least, most);
  }
}

void Penalty::right_hand_side(std::span<Vec3> force) const {
  parallel_for(
      force_.size(),
      [&](std::size_t c) {
        if (!active_[c]) {
          force[c].setZero();
          return;
        }
        const Vec3& n = normal_[c];
        force[c] = force_[c] - (implicit_time_[c] * scale_[c] * rate_[c]) * n -
                   friction_viscosity_[c] * (relative_[c] - n * n.dot(relative_[c]));
      },
      512);
  for (std::size_t i = 0; i < bonds_.size(); ++i)
    force[first_bond() + i] = active_[first_bond() + i] ? bonds_[i].force : Vec3::Zero();
}

void Penalty::settle_actions() {
  action_.resize(force_.size());
  parallel_for(
      force_.size(),
      [&](std::size_t c) {
        const double viscosity = active_[c] ? options_.dt * friction_viscosity_[c] : 0.0;
        const double across = active_[c] ? options_.dt * implicit_time_[c] * stiffness_[c] - viscosity : 0.0;
        action_[c] = {normal_[c], across, viscosity};
      },
      512);
  for (std::size_t i = 0; i < bonds_.size(); ++i) {
    const double acts = active_[first_bond() + i] ? 1.0 : 0.0;
    action_[first_bond() + i] = {bonds_[i].n, acts * bonds_[i].across, acts * bonds_[i].along};
  }
}

void Penalty::apply(std::span<const Vec3> delta, std::span<Vec3> force) const {
  parallel_for(
      force_.size(), [&](std::size_t c) { force[c] = apply(c, delta[c]); }, 512);
}

Mat3 Penalty::block(std::size_t c) const {
  const Action& a = action_[c];
  return (a.across + pressed_[c]) * a.n * a.n.transpose() + a.viscosity * Mat3::Identity();
}

void Penalty::forces(std::span<const Vec3> delta, std::span<Vec3> normal, std::span<Vec3> friction) const {
  parallel_for(
      force_.size(),
      [&](std::size_t c) {
        if (!active_[c]) {
          normal[c].setZero();
          friction[c].setZero();
          return;
        }
        const Vec3& n = normal_[c];
        const Vec3 after = relative_[c] + delta[c];
        normal[c] = force_[c] - implicit_time_[c] * (scale_[c] * rate_[c] + stiffness_[c] * n.dot(delta[c])) * n;
        friction[c] = -friction_viscosity_[c] * (after - n * n.dot(after));
      },
      512);
  for (std::size_t i = 0; i < bonds_.size(); ++i)
    if (active_[first_bond() + i]) normal[first_bond() + i] = bond_force(i, delta[first_bond() + i]);
}

}  // namespace brim
