#pragma once

#include <functional>
#include <string>
#include <vector>

#include "brim/scene/pairs/pair_table.h"

namespace brim {

/// What happened when one kind was dropped on another.
struct PairResult {
  std::string lower, upper;
  bool run = true;                    ///< false: two bodies that nothing moves never touch
  std::vector<std::string> failures;  ///< bounds that were not kept, in words; empty: good
  std::int64_t contacts = 0;          ///< most nodes at once that carried a force between the two
  /// [-] Worst of any step and body: what the body's map makes of the contact forces, against their sum, over the sum
  /// of their sizes. Negative: a body cannot tell.
  double linear = 0.0;
  double lever = 0.0;  ///< [m] the same of their torque: error over the sum of the sizes of the forces, a lever
  /// [-] Worst of any time and body: momentum gained since the start against the impulse of contact, over the whole
  /// impulse. What the body's own motion loses counts too.
  double drift = 0.0;
  double overlap = 0.0;   ///< [voxels] worst
  double energy = 0.0;    ///< [-] largest growth of the total energy, over that of the blow
  double leak = 0.0;      ///< [-] largest share on the wrong side
  double motion = 0.0;    ///< [-] the same without the energy of contact
  double speed = 0.0;     ///< [m/s] of the faster body at the end; of a table with a floor, as is what follows
  double under = 0.0;     ///< [-] share that came under the floor
  double carried = -1.0;  ///< [-] mean force of contact on the upper body over the last quarter, over its weight
  double force_lower = 0.0, force_upper = 0.0;  ///< [N] largest gain of momentum over a step; of contact where fixed
  double seconds = 0.0;                         ///< [s] of wall time a step
  int steps = 0;

  bool ok() const { return failures.empty(); }
};

/// Drops one kind on the other and measures. A body that nothing moves is always the lower one.
/// @throws InputError  for a kind that no scene can hold
/// Tests: tests/scene/pairs_test.cpp
PairResult run_pair(const PairTable& table, const PairKind& a, const PairKind& b);

/// Runs every unordered pair, each kind with itself included, in the order of the table.
/// @param only  pairs that hold one of these kinds; empty: all  @throws InputError  for a name that is none
/// @param each  called after each pair; false ends the run
/// @param run  makes the figures of a pair: run_pair, or what kept them
std::vector<PairResult> run_pairs(
    const PairTable& table, const std::vector<std::string>& only,
    const std::function<bool(const PairResult&)>& each = {},
    const std::function<PairResult(const PairTable&, const PairKind&, const PairKind&)>& run = run_pair);

}  // namespace brim
