#include "brim/world/free_flight.h"

#include <algorithm>
#include <cmath>

#include "brim/body/outer_forces.h"
#include "brim/body/walled.h"
#include "brim/core/interface_of.h"
#include "brim/world/contact_parameters.h"
#include "brim/world/contact_stage.h"
#include "brim/world/outer_actions.h"
#include "brim/world/part_filter.h"

namespace brim {

namespace {

/// Relative momentum of a rigid motion that may be missing for a body free to make it: rounding.
constexpr double kRounding = 1e-9;

}  // namespace

void FreeFlight::find(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
                      const ContactStage& stage, PartFilter& filter, const ContactParameters& laws,
                      const OuterActions& actions, const WorldOptions& options) {
  held_.assign(bodies.size(), 0), near_.assign(bodies.size(), 0);
  const auto approach = [&](std::int32_t a, std::int32_t b) {
    for (const std::int32_t p : {a, b}) near_[static_cast<std::size_t>(parts[p].body_index)] = 1;
  };
  const auto touch = [&](std::int32_t a, std::int32_t b) {
    for (const std::int32_t p : {a, b}) hold(static_cast<std::size_t>(parts[p].body_index));
  };
  for (const ContactPair& p : stage.contacts().pairs)
    if (p.begin < p.end) touch(p.part_a, p.part_b);
  stage.rigid().for_pairs(touch);
  stage.for_near([&](std::int32_t a, std::int32_t b) {
    const ConstraintPair law = laws.constraint_between(parts[a], parts[b], options);
    const bool bounces = law.constrained && law.restitution > 0.0;
    if (!bounces && filter.leaves_some(parts[a], parts[b])) approach(a, b);
  });
  actions.flag_pulled(near_), actions.flag_acted_on(held_);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const auto* outer = interface_of<OuterForces>(*bodies[b]);
    const bool in_a_box = interface_of<Walled>(*bodies[b]) != nullptr;
    if (in_a_box || (outer != nullptr && outer->has_outer_forces())) hold(b);
  }
}

void FreeFlight::set_back(const Body& body, double dt, std::span<const double> delta, std::span<const double> advanced,
                          std::span<double> q, std::span<const double> v) {
  const double m = body.mass();
  if (v.empty() || !std::isfinite(m) || !(m > 0.0)) return;
  // After finish_step moved a tree to a new pose, its joint velocities cannot be compared with those before.
  std::vector<double> motion(delta.begin(), delta.end());
  for (std::size_t i = 0; i < v.size() && q.size() == v.size(); ++i) motion[i] += v[i] - advanced[i];
  const Vec3 momentum = body.linear_momentum(motion);
  if (momentum == Vec3::Zero()) return;
  std::fill(motion.begin(), motion.end(), 0.0);
  if (!body.rigid_motion(momentum / m, Vec3::Zero(), motion)) return;
  body.filter(motion);
  if (!((body.linear_momentum(motion) - momentum).norm() <= kRounding * momentum.norm())) return;
  body.advance(-0.5 * dt, q, motion);
}

}  // namespace brim
