#include "brim/scene/pairs/pair_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "brim/body/walled.h"
#include "brim/scene/pairs/pair_sides.h"
#include "brim/scene/scene.h"

namespace brim {

namespace {

constexpr int kLower = 0, kUpper = 1;

/// Follows the momentum of one body against the impulse that contact gave it.
struct MomentumBook {
  Vec3 start = Vec3::Zero(), last = Vec3::Zero(), impulse = Vec3::Zero();  ///< [N s]
  double total = 0.0;                                                      ///< [N s] sum of the impulses' sizes
  double astray = 0.0;                                                     ///< [N s] largest difference
  double force = 0.0;  ///< [N] largest gain over a step, over the step

  void begin(const Vec3& p) { start = last = p; }
  /// @param walls  [N s] what the body took from walls of its own
  void add(const Vec3& p, const Vec3& contact_force, const Vec3& walls, double dt, bool movable) {
    impulse += dt * contact_force + walls;
    total += dt * contact_force.norm();
    force = std::max(force, movable ? (p - last).norm() / dt : contact_force.norm());
    if (movable) astray = std::max(astray, (p - start - impulse).norm());
    last = p;
  }
};

class Trial {
 public:
  Trial(const PairTable& table, const PairKind& lower, const PairKind& upper, World& world, PairResult& result)
      : bounds_(table.bounds),
        rests_(!lower.rolls && !upper.rolls),
        gap_(table.drop.gap),
        world_(world),
        result_(result),
        sides_(world.options().voxel_size > 0.0 ? world.options().voxel_size : world.body(kLower).part(0).voxel_size) {
    if (table.floor) floor_ = lower.lowest;
  }

  void run(int steps) {
    for (const int b : {kLower, kUpper}) {
      books_[b].begin(momentum(b));
      energy_start_ += kinetic(b) + world_.body(b).potential_energy(gravity());
    }
    blow_ = gravity().gravity.isZero() ? energy_start_ : kinetic(kUpper) - weight(kUpper).z() * gap_;
    for (int s = 0; s < steps && alive_; ++s) step(4 * s >= 3 * steps);
    conclude();
  }

 private:
  Vec3 momentum(int b) const { return movable(b) ? world_.body(b).linear_momentum(world_.v(b)) : Vec3(Vec3::Zero()); }
  Vec3 wall_impulse(int b) const {
    const auto* walled = dynamic_cast<const Walled*>(&world_.body(b));
    return walled ? walled->wall_impulse() : Vec3::Zero();
  }
  bool movable(int b) const { return std::isfinite(world_.body(b).mass()); }
  const Environment& gravity() const { return world_.options().environment; }
  double kinetic(int b) const { return world_.body(b).kinetic_energy(world_.v(b)); }
  /// [N]
  Vec3 weight(int b) const { return movable(b) ? Vec3(world_.body(b).mass() * gravity().gravity) : Vec3(Vec3::Zero()); }

  /// @param late  in the last quarter of the run
  void step(bool late) {
    const StepReport r = world_.step();
    ++result_.steps;
    result_.seconds += r.wall;
    alive_ = r.ok;
    substeps_ += r.substeps;
    for (const Warning& w : r.warnings)
      if (w.code == "no_convergence") unsolved_ = true;
    count_contacts();
    Vec3 force[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  // of contact, the floor's last
    for (const PairReport& pair : r.pairs) {
      force[world_.part(pair.part_a).body] += pair.force_on_a;
      force[world_.part(pair.part_b).body] -= pair.force_on_a;
    }
    for (const int b : {kLower, kUpper})
      books_[b].add(momentum(b), force[b], wall_impulse(b) + r.dt * weight(b), r.dt, movable(b));
    if (late) {
      late_force_ += r.dt * force[kUpper].z() + wall_impulse(kUpper).z();
      late_time_ += r.dt;
    }
    // Contact energy is reported as of the beginning of a step, all else as of its end.
    if (result_.steps > 1)
      note_energy(energy_end_ + r.contact_energy);
    else
      energy_start_ += r.contact_energy;  // of a body that touches the floor from the start
    energy_end_ = r.kinetic_energy + r.potential_energy;
    motion_most_ = std::max(motion_most_, energy_end_);
    result_.linear = std::max(result_.linear, r.momentum_error);
    // On a floor the two bodies reach differently far, and it is not told whose error is the worst.
    if (!floor_) result_.lever = std::max(result_.lever, r.angular_error * reach());
    result_.overlap = std::max(result_.overlap, r.worst_overlap);
    result_.leak = std::max(result_.leak, sides_.leaked(world_.body(kLower), world_.body(kUpper)));
  }

  void count_contacts() {
    std::int64_t count = 0;
    for (const ContactSample& c : world_.contacts())
      if (world_.part(c.part_a).body + world_.part(c.part_b).body == kLower + kUpper && c.force.norm() > 0.0f) ++count;
    result_.contacts = std::max(result_.contacts, count);
  }

  /// [m] The larger of the two bodies' greatest distances from their first contact with a force, and no less than a
  /// voxel: what angular_error is relative to.
  double reach() const {
    double most = world_.options().voxel_size;
    for (const int b : {kLower, kUpper}) {
      const ContactSample* first = nullptr;
      for (const ContactSample& c : world_.contacts()) {
        if (world_.part(c.part_a).body != b && world_.part(c.part_b).body != b) continue;
        if (c.force == Vec3f::Zero() && c.friction == Vec3f::Zero()) continue;
        if (!first) first = &c;
        most = std::max(most, static_cast<double>((c.position - first->position).norm()));
      }
    }
    return most;
  }

  void note_energy(double energy) { energy_most_ = std::max(energy_most_, energy); }

  void fail(bool failed, std::string reason) {
    if (failed) result_.failures.push_back(std::move(reason));
  }

  void conclude();
  void note_rest();

  const PairBounds& bounds_;
  std::optional<double> floor_;  // [m] height
  bool rests_;
  double gap_;
  World& world_;
  PairResult& result_;
  PairSides sides_;
  MomentumBook books_[2];
  static constexpr double kLeast = -std::numeric_limits<double>::infinity();
  double energy_start_ = 0.0, energy_end_ = 0.0, energy_most_ = kLeast, motion_most_ = kLeast;
  double blow_ = 0.0;                          // [J] that the two bring along
  double late_force_ = 0.0, late_time_ = 0.0;  // [N s], [s] of the last quarter
  std::int64_t substeps_ = 0;
  bool alive_ = true, unsolved_ = false;
};

void Trial::conclude() {
  PairResult& r = result_;
  r.seconds /= std::max(r.steps, 1);
  note_energy(energy_end_);
  r.energy = (energy_most_ - energy_start_) / blow_;
  r.motion = (motion_most_ - energy_start_) / blow_;
  for (const int b : {kLower, kUpper})
    if (books_[b].total > 0.0) r.drift = std::max(r.drift, books_[b].astray / books_[b].total);
  r.force_lower = books_[kLower].force;
  r.force_upper = books_[kUpper].force;
  if (floor_) note_rest();
  std::vector<double> motion;
  for (const int b : {kLower, kUpper}) {
    motion.resize(world_.body(b).v_size());
    if (movable(b) && !world_.body(b).rigid_motion(Vec3::UnitX(), Vec3::Zero(), motion)) r.linear = r.lever = -1.0;
  }

  fail(!alive_, fmt::format("step {} failed", r.steps));
  fail(unsolved_, "a solve did not converge");
  fail(substeps_ != r.steps, "a step was divided, so impulses are not all known");
  fail(r.contacts == 0, "no contact");
  fail(r.contacts > 0 && !(r.force_lower > 0.0 && r.force_upper > 0.0), "one side felt nothing");
  fail(!(r.overlap <= bounds_.overlap), fmt::format("overlap {:.2g} voxels", r.overlap));
  const double gained = floor_ ? r.motion : r.energy;
  fail(!(gained <= bounds_.energy), fmt::format("energy grew by {:.2g} %", 100.0 * gained));
  fail(!(r.drift <= bounds_.drift), fmt::format("{:.2g} % of the momentum not from contact", 100.0 * r.drift));
  // Above a floor, what rolls or flows off the other comes to its side.
  fail((!floor_ || rests_) && !(r.leak <= bounds_.leak), fmt::format("{:.2g} % leaked", 100.0 * r.leak));
  if (!floor_) return;
  fail(!(r.under <= bounds_.leak), fmt::format("{:.2g} % came under the floor", 100.0 * r.under));
  if (!rests_) return;
  fail(!(r.speed <= bounds_.speed), fmt::format("moves at {:.2g} m/s at the end", r.speed));
  fail(!(std::abs(r.carried - 1.0) <= bounds_.carried),
       fmt::format("{:.0f} % of the weight carried", 100.0 * r.carried));
}

void Trial::note_rest() {
  PairResult& r = result_;
  for (const int b : {kLower, kUpper}) {
    if (!movable(b)) continue;
    r.speed = std::max(r.speed, std::sqrt(2.0 * kinetic(b) / world_.body(b).mass()));
    r.under = std::max(r.under, sides_.below(world_.body(b), *floor_));
  }
  if (weight(kUpper).z() < 0.0 && late_time_ > 0.0) r.carried = -late_force_ / (late_time_ * weight(kUpper).z());
}

bool moves(const PairKind& kind, const PairTable& table) {
  const World world = build_world(parse_scene(pair_scene_text(table, kind, kind), kind.name));
  return std::isfinite(world.body(kLower).mass());
}

PairResult run_ordered(const PairTable& table, const PairKind& lower, const PairKind& upper) {
  PairResult result;
  result.lower = lower.name;
  result.upper = upper.name;
  World world = build_world(parse_scene(pair_scene_text(table, lower, upper), upper.name + "_on_" + lower.name));
  if (!std::isfinite(world.body(kLower).mass()) && !std::isfinite(world.body(kUpper).mass())) {
    result.run = false;
    return result;
  }
  Trial(table, lower, upper, world, result).run(table.drop.steps);
  const double linear = std::max(lower.linear, upper.linear), lever = std::max(lower.lever, upper.lever);
  if (result.linear < 0.0) result.failures.push_back("a body cannot tell its momentum");
  if (!(result.linear <= linear))
    result.failures.push_back(fmt::format("momentum error {:.1e}, stated {:.0e}", result.linear, linear));
  if (!(result.lever <= lever))
    result.failures.push_back(fmt::format("torque lost on a lever of {:.1e} m, stated {:.1g}", result.lever, lever));
  return result;
}

}  // namespace

PairResult run_pair(const PairTable& table, const PairKind& a, const PairKind& b) {
  return moves(a, table) && !moves(b, table) ? run_ordered(table, b, a) : run_ordered(table, a, b);
}

std::vector<PairResult> run_pairs(
    const PairTable& table, const std::vector<std::string>& only, const std::function<bool(const PairResult&)>& each,
    const std::function<PairResult(const PairTable&, const PairKind&, const PairKind&)>& run) {
  for (const std::string& name : only) table.find(name);
  const auto wanted = [&](const PairKind& kind) {
    return only.empty() || std::find(only.begin(), only.end(), kind.name) != only.end();
  };
  std::vector<PairResult> results;
  for (std::size_t i = 0; i < table.kinds.size(); ++i)
    for (std::size_t j = i; j < table.kinds.size(); ++j) {
      const PairKind &a = table.kinds[i], &b = table.kinds[j];
      if (!wanted(a) && !wanted(b)) continue;
      results.push_back(run(table, a, b));
      if (each && !each(results.back())) return results;
    }
  return results;
}

}  // namespace brim
