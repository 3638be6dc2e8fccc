#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/step_report.h"
#include "brim/world/world_part.h"

namespace brim {

/// Which bodies sleep. Bodies that touch each other are an island; one whose bodies have all been nearly still for half
/// a second falls asleep: its velocities become zero and the step leaves it out, its contacts too. It wakes as a whole
/// when something awake or moving touches it, when a velocity is given to it (prescribed, or set from outside) and when
/// it is told to. Part of the world's state, in its memory, so that a run that is resumed goes on bit for bit:
///   memory: [-0.5, n, n times (seconds of rest, island or -1), others ...]; only others where nothing rests
/// Tests: tests/world/sleep_test.cpp
class Sleep {
 public:
  /// [s] that an island must rest before it sleeps.
  static constexpr double kRest = 0.5;
  /// [voxels] by which a body may move in that time and still rest.
  static constexpr double kStir = 0.1;

  /// Lets the bodies sleep from now on; without it nothing does.
  void start(std::span<const std::unique_ptr<Body>> bodies);
  /// Other objects stand for the same bodies from now on: removed ones, and those that came back.
  void follow(std::span<const std::unique_ptr<Body>> bodies);
  bool on() const { return !island_.empty(); }
  bool asleep(std::size_t body) const { return on() && island_[body] >= 0; }
  int count() const;

  /// Takes what memory holds of it, and removes it there.
  void take(std::vector<double>& memory);
  /// Puts it before what memory holds.
  void keep(std::vector<double>& memory) const;

  /// Wakes the island of a body. @return true when it slept
  bool wake(std::size_t body);
  /// Marks parts whose body sleeps or, fixed, does not move: contacts between such parts change nothing.
  void mark(std::span<WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v) const;
  /// After a step of dt [s]: lets islands that have rested fall asleep, with zero velocity.
  /// @param pairs  of parts that touch
  void settle(std::span<const WorldPart> parts, std::span<const PairReport> pairs, double dt, std::span<double> v,
              std::span<const std::size_t> first_v);

 private:
  std::vector<const Body*> body_;
  std::vector<double> rest_;          ///< [s] per body: how long it has been nearly still
  std::vector<std::int32_t> island_;  ///< per body: a number of the island that sleeps, −1 for those awake
};

}  // namespace brim
