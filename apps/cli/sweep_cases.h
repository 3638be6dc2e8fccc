#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "brim/scene/parameters.h"

namespace brim::cli {

/// One run of a sweep.
struct SweepCase {
  std::vector<std::pair<std::string, std::string>> set;  ///< parameter and value as text, in the order given
  std::optional<std::uint64_t> seed;

  /// "h=0.01_seed=2": a folder's name that says the values; "run" where there are none.
  std::string name() const;
  SceneSettings settings() const;
  /// --set h=0.01 --seed 2
  std::vector<std::string> arguments() const;
};

/// All combinations, the last one fastest. @param set  "h=0.01,0.02"; commas within brackets and quotes do not divide
/// @param seeds  "1:5", "1,3,9", or "" for none
/// @throws InputError  for anything else, and more than a million cases
std::vector<SweepCase> sweep_cases(const std::vector<std::string>& set, const std::string& seeds);

/// Every number of the summaries of the cases in one table: a row each, with its values, how it ended, and what it
/// expected. @param folder  that holds a run folder for each case  @return  CSV (RFC 4180), a header first
std::string sweep_table(const std::string& folder, const std::vector<SweepCase>& cases);

/// How a case stands: "" where nothing is there, "begun" where it was cut short, or how its summary says it ended.
std::string sweep_state(const std::string& folder, const SweepCase& c);

}  // namespace brim::cli
