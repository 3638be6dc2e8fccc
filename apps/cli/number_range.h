#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <string>

namespace brim::cli {

/// Check of an option: a finite number within bounds; CLI::Range lets what is no number pass.
inline CLI::Validator number_range(double least, double most) {
  return {[least, most](const std::string& text) {
            double x = 0.0;
            const auto [end, bad] = std::from_chars(text.data(), text.data() + text.size(), x);
            const bool good = bad == std::errc() && end == text.data() + text.size() && x >= least && x <= most;
            return good ? std::string()
                        : fmt::format("{} is not allowed; must be from {:g} to {:g}", text, least, most);
          },
          fmt::format("{:g} to {:g}", least, most)};
}

}  // namespace brim::cli
