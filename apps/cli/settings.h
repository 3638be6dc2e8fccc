#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "brim/scene/parameters.h"

namespace brim::cli {

/// --set and --seed of commands that take a scene.
struct SettingOptions {
  std::vector<std::string> set;
  std::int64_t seed = -1;  ///< none

  void add_to(CLI::App& command) {
    command
        .add_option("--set", set,
                    "name=value of a parameter of the scene, or of any of its values (/world/time_step=0.01); may be "
                    "given more than once")
        ->allow_extra_args(false);
    command
        .add_option(
            "--seed", seed,
            "other random numbers: 1 is the scene as written; goes to the parameter \"seed\" where there is one")
        ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 53));
  }
  SceneSettings read() const {
    SceneSettings s;
    for (const std::string& text : set) {
      auto [name, value] = read_setting(text);
      s.set[name] = std::move(value);
    }
    if (seed >= 0) s.seed = static_cast<std::uint64_t>(seed);
    return s;
  }
};

}  // namespace brim::cli
