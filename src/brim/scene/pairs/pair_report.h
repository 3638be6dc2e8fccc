#pragma once

#include <span>
#include <string>

#include "brim/scene/pairs/pair_trial.h"

namespace brim {

/// One line for a terminal: the two kinds, the results, and "good" or the failures.
std::string pair_line(const PairResult& result);
/// The heading of such lines.
std::string pair_line_head();

/// Error of a map as text: "0", "3e-16", or "untold".
std::string pair_error_text(double error);
/// The violated bounds, in words.
std::string pair_failures(const PairResult& result);

/// JSON: {"name": of its world, "drop": ..., "pairs": [{"lower", "upper", "run", "ok", "failures", figures}]}.
std::string pairs_json(const PairTable& table, std::span<const PairResult> results);

}  // namespace brim
