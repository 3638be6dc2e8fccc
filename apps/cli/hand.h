#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "brim/world/world.h"

namespace brim::cli {

/// What a person does to the bodies of a run while it is made: takes hold of one in the viewer, pulls it about and lets
/// it go. It comes through a socket from the process that serves the page, and happens before the next step. All of it
/// is written down as the timeline of a scene, pulls.json in the folder of the run: a scene that includes it does the
/// same, bit for bit. Tests: tests/apps/interactive_test.cpp
class Hand {
 public:
  /// @throws InputError  where there is no socket to be had
  Hand();
  ~Hand();
  Hand(const Hand&) = delete;
  Hand& operator=(const Hand&) = delete;

  /// The end for the process that serves the page.
  int far_end() const { return ends_[1]; }
  /// Where it is written down; what a run that is gone on with has there stays. @throws InputError
  void write_to(const std::string& folder, bool go_on);
  /// Waits until the world's next step is due, by the clock, and takes what was asked for meanwhile.
  void before_step(World& world);
  /// Writes what there is to be written.
  void finish();

 private:
  void take(World& world, const std::string& asked);

  int ends_[2] = {-1, -1};
  std::string file_;
  std::vector<std::string> entries_;  ///< of the timeline, as text
  bool written_ = true;
  std::chrono::steady_clock::time_point due_{};
};

}  // namespace brim::cli
