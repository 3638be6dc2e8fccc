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

/// How coarsely contact sees bodies (docs/levels.md). A body at level l meets others in voxels 2^l times as wide.
struct LevelOptions {
  /// Levels that stay, by name of the body or of all its numbered copies; others are chosen.
  std::map<std::string, int> bodies;
  std::optional<Vec3> interest;  ///< [m] the farther a body is from here, the coarser: level 1 + log2(distance / near)
  double near = 1.0;             ///< [m] bodies closer than this stay at level 0
  int most = 3;                  ///< coarsest level that is chosen, at most 8
  /// [s] of a step: while steps take longer, bodies get coarser. 0: no such bound; with one, levels follow the clock,
  /// and a run is the same again only with the levels that it recorded.
  double budget = 0.0;
  bool average = true;  ///< coarse densities are means of fine ones; false: samples
  int interval = 1;     ///< steps from one choice to the next
};

/// Lets contact see the bodies of a world so from now on. All of it becomes part of the world's state, in its memory.
/// @throws InputError  for numbers out of range
void set_levels(World& world, const LevelOptions& options);
/// The levels that the next step takes instead of choosing. @param levels  shape (bodies)
/// @throws InputError  for other shapes, and where no levels were set
void follow_levels(World& world, std::span<const int> levels);
/// At which level each body was seen last, shape (bodies); empty where no levels were set.
std::vector<int> levels_in(const State& state);

/// At which level contact sees each body (the paper, section 4.1), and how a change of level is made gentle. Part of
/// the world's state, so that a run that is resumed goes on bit for bit:
///   memory: [-0.25, numbers that follow, those ..., others ...]
/// Tests: tests/world/levels_test.cpp
class Levels {
 public:
  bool on() const { return !level_.empty(); }
  bool average() const { return options_.average; }
  int level(std::size_t body) const { return body < level_.size() ? level_[body] : 0; }

  /// Takes what memory holds of it, and removes it there; without any, all levels are 0. @param bodies  of the world
  void take(std::vector<double>& memory, std::span<const std::unique_ptr<Body>> bodies);
  /// Puts it before what memory holds.
  void keep(std::vector<double>& memory) const;

  /// Chooses the levels of a step. @return true when one has changed
  bool choose(std::int64_t step, std::span<const std::unique_ptr<Body>> bodies);
  /// Gives the parts the levels of their bodies.
  void mark(std::span<WorldPart> parts) const;
  /// What a step took, [s] of wall time.
  void took(double seconds) { seconds_ += seconds, ++timed_; }
  LevelShift& shift() { return shift_; }

 private:
  friend void set_levels(World&, const LevelOptions&);
  friend void follow_levels(World&, std::span<const int>);
  friend std::vector<int> levels_in(const State&);
  /// What memory holds of it; how many numbers that is.
  std::size_t read(std::span<const double> memory);

  LevelOptions options_;      // but the names
  std::vector<int> fixed_;    // per body; −1: chosen
  std::vector<int> level_;    // per body
  int bias_ = 0;              // by which the budget has made what is chosen coarser
  bool told_ = false;         // the next levels are those that are there
  std::vector<int> changed_;  // per body: what it was before it was told
  double seconds_ = 0.0;      // since the last choice, of so many steps
  int timed_ = 0;
  LevelShift shift_;
};

}  // namespace brim
