#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/world_part.h"

namespace brim {

class ContactParameters;
class ContactStage;
class OuterActions;
class PartFilter;
struct WorldOptions;

/// Second-order positions for bodies in free flight: a body without contacts, links or position-dependent forces in a
/// sub-step moves by the mean of its velocity before and after,
///   x ← x + dt (v + v⁺)/2 = x + dt v⁺ − dt/2 Δc,   Δc: change of the velocity of the centre of mass
/// so that a throw follows its parabola, and keeps its energy, at any step. Only the body as a whole is set back:
/// internal motion, and all bodies with contact, move by x + dt v⁺, which makes stiff forces stable. That rule loses
/// the energy m g² dt²/2 per step and does not affect velocities, so switching between the two adds no energy.
/// Bodies within some voxels of others do not count as flying, contacts or not: the loss damps small hops at rest.
/// Pairs that bounce by restitution (rows) fly at once, as their velocities are those of the parabola.
/// Excluded: fixed and partly fixed bodies, trees with a fixed base, fluids in a box of their own, and own bodies whose
/// coordinates cannot be shifted.
class FreeFlight {
 public:
  /// Finds the flying bodies, once contacts and links of the sub-step are known.
  void find(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts, const ContactStage& stage,
            PartFilter& filter, const ContactParameters& laws, const OuterActions& actions,
            const WorldOptions& options);
  /// Marks a body as not flying: something else acts on it.
  void hold(std::size_t body) { near_[body] = held_[body] = 1; }
  bool flies(std::size_t body) const { return near_[body] == 0; }
  /// True for a body that nothing but uniform gravity has acted on, however near others are.
  bool is_free(std::size_t body) const { return held_[body] == 0; }
  /// Sets a body back by dt/2 Δc, after its finish_step.
  /// @param delta     v⁺ − v of the body, as solved
  /// @param advanced  v⁺ by which its positions were advanced
  /// @param q, v      of the body, now: changes of velocities made by finish_step count as well
  static void set_back(const Body& body, double dt, std::span<const double> delta, std::span<const double> advanced,
                       std::span<double> q, std::span<const double> v);

 private:
  std::vector<std::uint8_t> near_, held_;  // per body: may be touched soon, or held; held
};

}  // namespace brim
