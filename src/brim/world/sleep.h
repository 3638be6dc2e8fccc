#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/step_report.h"
#include "brim/world/world_part.h"

namespace brim {

/// Decides which bodies sleep. Bodies that touch each other form an island; an island whose bodies have all been nearly
/// still for half a second falls asleep: its velocities become zero and the step leaves out its bodies and their
/// contacts. It wakes as a whole when an awake or moving body touches it, when it is given a velocity (prescribed, or
/// set from outside), while a force or wind on one of its bodies changes with time, when forces or shape of one change
/// by themselves (TimeDriven), and on request. Part of the world's state, in its memory, so that a resumed run
/// continues bit for bit:
///   memory: [-0.5, n, n times (seconds of rest, island or -1), others ...]; only others when no body rests
/// Tests: tests/world/sleep_test.cpp
class Sleep {
 public:
  /// [s] rest of an island before it sleeps.
  static constexpr double kRest = 0.5;
  /// [voxels] motion in that time up to which a body counts as resting.
  static constexpr double kStir = 0.1;

  /// Enables sleep; without this call no body sleeps.
  void start(std::span<const std::unique_ptr<Body>> bodies);
  /// To be called when bodies have been replaced by other objects: removed, or brought back.
  void follow(std::span<const std::unique_ptr<Body>> bodies);
  bool on() const { return !island_.empty(); }
  bool asleep(std::size_t body) const { return body < island_.size() && island_[body] >= 0; }
  int count() const;

  /// Reads and removes its part of memory.
  void take(std::vector<double>& memory);
  /// Writes it in front of the rest of memory.
  void keep(std::vector<double>& memory) const;

  /// Wakes the island of a body. @return true if it was asleep
  bool wake(std::size_t body);
  /// Marks parts whose body sleeps or is fixed and still: contacts between such parts have no effect.
  void mark(std::span<WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v) const;
  /// After a step of dt [s]: puts rested islands to sleep, with zero velocity.
  /// @param pairs  of parts that touch
  /// @param held   bodies that stay awake, with their islands, shape (bodies)
  /// @param driven  whether a body changes by itself; asked only of those that have rested long enough to sleep
  void settle(std::span<const WorldPart> parts, std::span<const PairReport> pairs, double dt,
              std::span<const std::uint8_t> held, const std::function<bool(std::size_t)>& driven, std::span<double> v,
              std::span<const std::size_t> first_v);

 private:
  std::vector<const Body*> body_;
  std::vector<double> rest_;          ///< [s] per body: how long it has been nearly still
  std::vector<std::int32_t> island_;  ///< per body: number of its sleeping island, −1 when awake
};

}  // namespace brim
