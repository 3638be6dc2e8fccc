#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "brim/scene/document.h"

namespace brim {

class ErrorList;

/// What is asked of a scene from outside it: `--set h=0.02`, `--seed 3`.
struct SceneSettings {
  std::map<std::string, Json> set;    ///< parameter, or JSON pointer ("/world/time_step") -> value
  std::optional<std::uint64_t> seed;  ///< see apply_seed

  bool empty() const { return set.empty() && !seed; }
};

/// Reads "name=value": JSON where it is JSON, else text. @throws InputError  when there is no name or no "="
std::pair<std::string, Json> read_setting(const std::string& text);

/// Takes "parameters" out of the root and puts their values in place of every string "=expression" (a string that
/// begins with "==" stands for itself without the first). Parameters may be computed from each other.
///   "parameters": {"h": 0.02, "side": "=20*h", "label": {"value": "a", "description": "..."}}
/// Values of the settings replace those of parameters, or of what a JSON pointer names.
/// Unknown names, circles and values of another type are collected in `errors`; what uses them stays as it is written.
/// Tests: tests/scene/parameters_test.cpp
void apply_parameters(Document& document, const SceneSettings& settings, ErrorList& errors);

/// Seed 1 is the scene as it is written. Another one goes to the parameter "seed" where the scene has it; else it is
/// counted on from every "seed" of the scene, those that are left to their default too.
/// @throws InputError  when nothing of the scene is random
void apply_seed(Document& document, std::uint64_t seed);

}  // namespace brim
