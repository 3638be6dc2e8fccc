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

/// Bodies in free flight fall to second order: what has no contact, link or force that depends on its place in a
/// sub-step moves by the mean of its velocity before and after,
///   x ← x + dt (v + v⁺)/2 = x + dt v⁺ − dt/2 Δc,   Δc: change of the velocity of the centre of mass
/// so that a throw lies on its parabola, and keeps its energy, at any step. Only the body as a whole is set back:
/// what its matter does about the centre of mass, and all that contact touches, moves by x + dt v⁺, which is what
/// makes stiff forces stable. That rule loses the energy m g² dt²/2 a step and leaves velocities alike, so that no
/// change from one to the other adds any.
/// What lies within some voxels of others does not fly, contacts or not: the loss stills what hops at rest. Pairs that
/// bounce by restitution (rows) are let go at once, as their velocities are those of the parabola.
/// Left out: fixed and partly fixed bodies, trees with a fixed base, fluids in a box of their own, and own bodies
/// whose coordinates cannot carry them along.
/// Same bits for any number of threads.  Tests: tests/world/free_flight_test.cpp
class FreeFlight {
 public:
  /// Finds them, once contacts and links of the sub-step are known.
  void find(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts, const ContactStage& stage,
            PartFilter& filter, const ContactParameters& laws, const OuterActions& actions,
            const WorldOptions& options);
  /// Says of one that it does not fly: something else acts on it.
  void hold(std::size_t body) { held_[body] = 1; }
  bool flies(std::size_t body) const { return held_[body] == 0; }
  /// Sets one back by dt/2 Δc, after its finish_step.
  /// @param delta     v⁺ − v of the body, as solved
  /// @param advanced  v⁺ by which it was advanced
  /// @param q, v      of the body, as they now are: what finish_step has given velocities of places counts as well
  static void set_back(const Body& body, double dt, std::span<const double> delta, std::span<const double> advanced,
                       std::span<double> q, std::span<const double> v);

 private:
  std::vector<std::uint8_t> held_;  // per body
};

}  // namespace brim
