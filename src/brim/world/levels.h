#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "brim/world/level_shift.h"
#include "brim/world/world.h"
#include "brim/world/world_part.h"

namespace brim {

/// Resolution of contact per body (docs/levels.md). A body at level l meets others in voxels 2^l times as wide.
struct LevelOptions {
  /// Fixed levels, by name of the body or of all its numbered copies; others are chosen.
  std::map<std::string, int> bodies;
  std::optional<Vec3> interest;  ///< [m] level rises with the distance from here: 1 + log2(distance / near)
  double near = 1.0;             ///< [m] bodies closer than this stay at level 0
  int most = 3;                  ///< coarsest level to be chosen, at most 8
  /// [s] wall time of a step: while steps take longer, bodies get coarser. 0: no limit. With a limit, levels depend on
  /// the clock, and a run is only reproduced with its recorded levels.
  double budget = 0.0;
  bool average = true;  ///< coarse densities are means of fine ones; false: samples
  int interval = 1;     ///< steps between choices
};

/// Sets the levels of a world's bodies from now on. They become part of the world's state, in its memory.
/// @throws InputError  for numbers out of range
void set_levels(World& world, const LevelOptions& options);
/// Sets the levels of the next step instead of choosing them. @param levels  shape (bodies)
/// @throws InputError  for other shapes, and when set_levels was not called
void follow_levels(World& world, std::span<const int> levels);
/// Last level of each body, shape (bodies); empty when set_levels was not called.
std::vector<int> levels_in(const State& state);

/// The level at which contact resolves each body (paper, section 4.1), with smoothing of its changes. Part of the
/// world's state, so that a resumed run continues bit for bit:
///   memory: [-0.25, count of numbers, numbers ..., others ...]
/// Tests: tests/world/levels_test.cpp
class Levels {
 public:
  bool on() const { return !level_.empty(); }
  bool average() const { return options_.average; }
  int level(std::size_t body) const { return body < level_.size() ? level_[body] : 0; }

  /// Reads and removes its part of memory; without any, all levels are 0. @param bodies  of the world
  void take(std::vector<double>& memory, std::span<const std::unique_ptr<Body>> bodies);
  /// Writes it in front of the rest of memory.
  void keep(std::vector<double>& memory) const;

  /// Chooses the levels of a step. @return true when one has changed
  bool choose(std::int64_t step, std::span<const std::unique_ptr<Body>> bodies);
  /// Sets the parts' levels to those of their bodies.
  void mark(std::span<WorldPart> parts) const;
  /// Records the wall time of a step, [s].
  void took(double seconds) { seconds_ += seconds, ++timed_; }
  LevelShift& shift() { return shift_; }

 private:
  friend void set_levels(World&, const LevelOptions&);
  friend void follow_levels(World&, std::span<const int>);
  friend std::vector<int> levels_in(const State&);
  /// Reads its part of memory. @return count of its numbers
  std::size_t read(std::span<const double> memory);

  LevelOptions options_;      // except names
  std::vector<int> fixed_;    // per body; −1: chosen
  std::vector<int> level_;    // per body
  int bias_ = 0;              // levels added by the budget to the chosen ones
  bool told_ = false;         // the next levels are given, not chosen
  std::vector<int> changed_;  // per body: level before it was given
  double seconds_ = 0.0;      // since the last choice, over timed_ steps
  int timed_ = 0;
  LevelShift shift_;
};

}  // namespace brim
