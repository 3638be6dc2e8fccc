#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "brim/world/measures.h"
#include "brim/world/world.h"

namespace brim {

/// How a run ended.
enum class RunEnd { Completed, Interrupted, Failed };

/// "completed", "interrupted" or "failed".
const char* run_end_word(RunEnd end);

/// Totals of a run, accumulated frame by frame.
class RunTotals {
 public:
  /// @param steps  number of steps in the frame; 0 for the first frame
  void add(const StepReport& frame, int steps);
  void warn(const Warning& warning);

  struct Count {
    double sum = 0.0, largest = 0.0;
  };
  std::int64_t frames = 0, steps = 0, substeps = 0, solves = 0;
  double wall = 0.0;  ///< [s] in steps
  std::array<double, static_cast<std::size_t>(Phase::Count)> seconds{};
  double contact_seconds = 0.0;
  std::map<std::string, Count> counts;  ///< contacts, tiles, ...; largest: of a frame divided by its steps
  double worst_overlap = 0.0, worst_overlap_time = 0.0;
  int worst_part_a = -1, worst_part_b = -1;  ///< -1: no pair had it at the end of a frame
  double worst_pair_overlap = 0.0;
  double momentum_error = 0.0, angular_error = 0.0, cg_residual = 0.0, row_residual = 0.0;
  double energy_first = 0.0, energy_last = 0.0, energy_largest = 0.0;  ///< [J] kinetic + potential + contact
  StepReport last;
  std::size_t warning_count = 0;
  std::map<std::string, std::size_t> warning_codes;
  std::vector<Warning> warnings;  ///< the first kWarningsKept
  static constexpr std::size_t kWarningsKept = 200;
};

/// Data about the process and the whole run, unknown to single steps.
struct RunFacts {
  std::string scene_name, scene_file;
  int threads = 1;
  std::int64_t frames_wanted = 0;
  double frame_time = 0.0;  ///< [s]
  double wall = 0.0;        ///< [s] from the first step to the last record
  double build_wall = 0.0;  ///< [s] reading the scene and building the world
  RunEnd end = RunEnd::Completed;
};

/// The text of summary.json (docs/formats.md). NaN is written as null.
std::string summary_text(const World& world, const RunTotals& totals, const RunFacts& facts,
                         const std::vector<ExpectationResult>& findings);

/// Peak resident memory of this process, [bytes]; 0 if the system does not give it.
double peak_memory();

}  // namespace brim
