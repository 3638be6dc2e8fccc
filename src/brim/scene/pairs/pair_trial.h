#pragma once

#include <functional>
#include <string>
#include <vector>

#include "brim/scene/pairs/pair_table.h"

namespace brim {

/// Results of dropping one kind on another.
struct PairResult {
  std::string lower, upper;
  bool run = true;                    ///< false: two immobile bodies, which never touch
  std::vector<std::string> failures;  ///< violated bounds, in words; empty: good
  std::int64_t contacts = 0;          ///< largest number of nodes with a force between the two
  /// [-] Worst of any step and body: resultant of the mapped contact forces minus the sum of the forces, over the sum
  /// of their magnitudes. Negative: unknown.
  double linear = 0.0;
  double lever = 0.0;  ///< [m] the same for their torque: error over the sum of the forces' magnitudes, a lever
  /// [-] Worst of any time and body: momentum gained since the start minus the impulse of contact, over the total
  /// impulse. Includes losses of the body's own motion.
  double drift = 0.0;
  double overlap = 0.0;   ///< [voxels] worst
  double energy = 0.0;    ///< [-] largest growth of the total energy, over that of the impact
  double leak = 0.0;      ///< [-] largest fraction on the wrong side
  double motion = 0.0;    ///< [-] the same without the energy of contact
  double speed = 0.0;     ///< [m/s] of the faster body at the end; for tables with a floor, like the following
  double under = 0.0;     ///< [-] fraction below the floor
  double carried = -1.0;  ///< [-] mean force of contact on the upper body over the last quarter, over its weight
  double force_lower = 0.0, force_upper = 0.0;  ///< [N] largest gain of momentum over a step; of contact where fixed
  double seconds = 0.0;                         ///< [s] of wall time a step
  int steps = 0;

  bool ok() const { return failures.empty(); }
};

/// Drops one kind on the other and measures. An immobile body is always the lower one.
/// @throws InputError  for a kind that no scene can contain
/// Tests: tests/scene/pairs_test.cpp
PairResult run_pair(const PairTable& table, const PairKind& a, const PairKind& b);

/// Runs every unordered pair, including each kind with itself, in the order of the table.
/// @param only  pairs with one of these kinds; empty: all  @throws InputError  for an unknown name
/// @param each  called after each pair; false ends the run
/// @param run  computes a pair's results: run_pair, or a cache of it
std::vector<PairResult> run_pairs(
    const PairTable& table, const std::vector<std::string>& only,
    const std::function<bool(const PairResult&)>& each = {},
    const std::function<PairResult(const PairTable&, const PairKind&, const PairKind&)>& run = run_pair);

}  // namespace brim
