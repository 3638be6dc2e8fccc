#pragma once

#include <span>
#include <string>

#include "brim/scene/pairs/pair_trial.h"

namespace brim {

/// One line for a terminal: the two kinds, the figures, and "good" or what failed.
std::string pair_line(const PairResult& result);
/// The heading of such lines.
std::string pair_line_head();

/// JSON: {"name": of its world, "drop": ..., "pairs": [{"lower", "upper", "run", "ok", "failures", figures}]}.
std::string pairs_json(const PairTable& table, std::span<const PairResult> results);

/// A Markdown page: what is done, a matrix of all pairs, a table of figures, and the kinds with what their maps state.
/// @param command  that made it
std::string pairs_markdown(const PairTable& table, std::span<const PairResult> results, const std::string& command);
/// A section of that page about another world of the same table: its matrix, and the figures of pairs that fail.
std::string pairs_section(const PairTable& table, std::span<const PairResult> results);

}  // namespace brim
