#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "brim/scene/document.h"

namespace brim {

class ErrorList;

/// Settings of a scene from outside it: `--set h=0.02`, `--seed 3`.
struct SceneSettings {
  std::map<std::string, Json> set;    ///< parameter, or JSON pointer ("/world/time_step") -> value
  std::optional<std::uint64_t> seed;  ///< see apply_seed

  bool empty() const { return set.empty() && !seed; }
};

/// Parses "name=value": the value as JSON if possible, else as text. @throws InputError  when there is no name or no
/// "="
std::pair<std::string, Json> read_setting(const std::string& text);

/// Removes "parameters" from the root and replaces every string "=expression" by its value (a string that begins with
/// "==" stands for itself without the first). Parameters may be computed from each other.
///   "parameters": {"h": 0.02, "side": "=20*h", "label": {"value": "a", "description": "..."}}
/// Settings replace the values of parameters, or of JSON pointers. Unknown names, cycles and values of another type are
/// collected in `errors`; expressions that use them stay unevaluated.
/// Tests: tests/scene/parameters_test.cpp
void apply_parameters(Document& document, const SceneSettings& settings, ErrorList& errors);

/// Seed 1 leaves the scene unchanged. Another seed is assigned to the parameter "seed" if there is one; else it is an
/// offset on every "seed" of the scene, including defaults.
/// @throws InputError  when nothing of the scene is random
void apply_seed(Document& document, std::uint64_t seed);

}  // namespace brim
