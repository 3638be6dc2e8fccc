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

/// A Markdown page: the procedure, a matrix of all pairs, reasons of failures, the kinds with the errors of their maps,
/// results; and a section for each further world, with its matrix, reasons of failures and their results.
/// @param runs  at least one, of the same kinds
/// @param command  by which it was made
/// Tests: tests/scene/pair_page_test.cpp
std::string pairs_markdown(std::span<const PairRun> runs, const std::string& command);

/// A list item for each note of the table about failed pairs, with their names, and one for all pairs without a note.
std::string why_some_fail(const PairRun& run);

}  // namespace brim
