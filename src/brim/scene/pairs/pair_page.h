#pragma once

#include <span>
#include <string>
#include <vector>

#include "brim/scene/pairs/pair_trial.h"

namespace brim {

/// All pairs of a table in one of its worlds.
struct PairRun {
  PairTable table;
  std::vector<PairResult> results;
};

/// A Markdown page: what is done, a matrix of all pairs, why some fail, the kinds with what their maps state, figures;
/// and a section for each further world, with its matrix, why some fail and the figures of these.
/// @param runs  at least one, of the same kinds
/// @param command  that made it
/// Tests: tests/scene/pair_page_test.cpp
std::string pairs_markdown(std::span<const PairRun> runs, const std::string& command);

/// A list item for each note of the table about pairs that failed, with their names, and one for all that no note is
/// about.
std::string why_some_fail(const PairRun& run);

}  // namespace brim
