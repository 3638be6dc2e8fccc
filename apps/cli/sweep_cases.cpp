#include "sweep_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "brim/core/error.h"
#include "brim/io/regular_file.h"

namespace brim::cli {

namespace {

namespace fs = std::filesystem;
using SummaryJson = nlohmann::ordered_json;

constexpr std::size_t kMaxCases = 1'000'000, kMaxName = 120;

/// "0.1,[1,2],0.3" -> three.
std::vector<std::string> divided(const std::string& text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  bool quoted = false;
  for (const char c : text) {
    if (c == '"') quoted = !quoted;
    if (!quoted && (c == '[' || c == '{' || c == '(')) ++depth;
    if (!quoted && (c == ']' || c == '}' || c == ')')) --depth;
    if (c == ',' && depth == 0 && !quoted)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

std::uint64_t seed_of(const std::string& text, const std::string& all) {
  std::uint64_t n = 0;
  const auto [end, bad] = std::from_chars(text.data(), text.data() + text.size(), n);
  if (bad != std::errc() || end != text.data() + text.size())
    throw InputError(fmt::format("--seeds {}: must be first:last, or whole numbers with commas", all));
  return n;
}

std::vector<std::uint64_t> seeds_of(const std::string& text) {
  std::vector<std::uint64_t> seeds;
  if (text.empty()) return seeds;
  for (const std::string& part : divided(text)) {
    const auto colon = part.find(':');
    const std::uint64_t first = seed_of(part.substr(0, colon), text);
    const std::uint64_t last = colon == std::string::npos ? first : seed_of(part.substr(colon + 1), text);
    if (last < first || last - first >= kMaxCases)
      throw InputError(fmt::format("--seeds {}: must rise, by less than {}", text, kMaxCases));
    for (std::uint64_t s = first; s <= last; ++s) {
      if (std::find(seeds.begin(), seeds.end(), s) != seeds.end())
        throw InputError(fmt::format("--seeds {}: {} is there twice", text, s));
      seeds.push_back(s);
    }
  }
  return seeds;
}

/// Numbers of a summary as "energy.first"; lists are left out.
void flatten(const SummaryJson& value, const std::string& name, std::vector<std::pair<std::string, std::string>>& row) {
  if (value.is_object())
    for (const auto& [key, member] : value.items()) flatten(member, name.empty() ? key : name + "." + key, row);
  else if (value.is_number() || value.is_boolean())
    row.emplace_back(name, value.dump());
  else if (value.is_string() && (name == "end" || name == "hash"))
    row.emplace_back(name, value.get<std::string>());
}

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::optional<SummaryJson> summary_of(const fs::path& folder) {
  const auto text = read_regular_file((folder / "summary.json").string());
  if (!text) return std::nullopt;
  SummaryJson json = SummaryJson::parse(*text, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  return json;
}

std::vector<std::pair<std::string, std::string>> row_of(const std::string& folder, const SweepCase& c) {
  std::vector<std::pair<std::string, std::string>> row = c.set;
  if (c.seed) row.emplace_back("seed", std::to_string(*c.seed));
  row.emplace_back("folder", c.name());
  const std::optional<SummaryJson> summary = summary_of(fs::path(folder) / c.name());
  if (!summary) {
    row.emplace_back("end", sweep_state(folder, c));
    return row;
  }
  flatten(*summary, "", row);
  if (summary->contains("expect") && summary->at("expect").is_array())
    for (const SummaryJson& e : summary->at("expect")) {
      if (!e.is_object()) continue;
      const std::string name = "expect." + e.value("metric", "") +
                               (e.contains("body") ? "." + e.value("body", "") : "") +
                               (e.contains("sensor") ? "." + e.value("sensor", "") + "." + e.value("channel", "") : "");
      const bool again = std::any_of(row.begin(), row.end(), [&](const auto& cell) { return cell.first == name; });
      if (!again && e.contains("value")) row.emplace_back(name, e.at("value").dump());
    }
  return row;
}

}  // namespace

std::string SweepCase::name() const {
  std::string text;
  for (const auto& [key, value] : set) text += (text.empty() ? "" : "_") + key + "=" + value;
  if (seed) text += fmt::format("{}seed={}", text.empty() ? "" : "_", *seed);
  if (text.empty()) return "run";
  const std::string whole = text;
  bool plain = true;
  for (char& c : text) {
    const bool good =
        std::isalnum(static_cast<unsigned char>(c)) || std::string_view("=_.+-").find(c) != std::string::npos;
    if (!good) c = '-', plain = false;
  }
  if (text.starts_with('.')) text[0] = '-', plain = false;
  if (plain && text.size() <= kMaxName) return text;
  // What was cut off or replaced still tells two cases apart (FNV-1a).
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : whole) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return fmt::format("{}_{:08x}", text.substr(0, kMaxName), static_cast<std::uint32_t>(hash ^ (hash >> 32)));
}

SceneSettings SweepCase::settings() const {
  SceneSettings s;
  for (const auto& [key, value] : set) {
    auto [name, read] = read_setting(key + "=" + value);
    s.set[name] = std::move(read);
  }
  s.seed = seed;
  return s;
}

std::vector<std::string> SweepCase::arguments() const {
  std::vector<std::string> words;
  for (const auto& [key, value] : set) {
    words.push_back("--set");
    words.push_back(key + "=" + value);
  }
  if (seed) {
    words.push_back("--seed");
    words.push_back(std::to_string(*seed));
  }
  return words;
}

std::vector<SweepCase> sweep_cases(const std::vector<std::string>& set, const std::string& seeds) {
  std::vector<SweepCase> cases(1);
  const auto multiply = [&](std::size_t n) {
    if (cases.size() * n > kMaxCases)
      throw InputError(fmt::format("the sweep has more than {} cases; at most that many are allowed", kMaxCases));
  };
  for (const std::string& text : set) {
    read_setting(text);
    const std::string key = text.substr(0, text.find('='));
    const std::vector<std::string> values = divided(text.substr(text.find('=') + 1));
    multiply(values.size());
    std::vector<SweepCase> next;
    for (const SweepCase& c : cases) {
      for (const auto& [other, unused] : c.set)
        if (other == key) throw InputError(fmt::format("--set {}: it is set twice; give its values with commas", key));
      for (const std::string& value : values) {
        if (std::count(values.begin(), values.end(), value) > 1)
          throw InputError(fmt::format("--set {}: {} is there twice", text, value));
        next.push_back(c);
        next.back().set.emplace_back(key, value);
      }
    }
    cases = std::move(next);
  }
  const std::vector<std::uint64_t> all = seeds_of(seeds);
  if (all.empty()) return cases;
  multiply(all.size());
  std::vector<SweepCase> next;
  for (const SweepCase& c : cases)
    for (const std::uint64_t s : all) {
      next.push_back(c);
      next.back().seed = s;
    }
  return next;
}

std::string sweep_state(const std::string& folder, const SweepCase& c) {
  const fs::path run = fs::path(folder) / c.name();
  if (const auto summary = summary_of(run)) {
    const std::string end = summary->value("end", "");
    return end == "interrupted" ? "begun" : end;
  }
  std::error_code error;
  return fs::exists(run / "run.h5", error) ? "begun" : "";
}

std::string sweep_table(const std::string& folder, const std::vector<SweepCase>& cases) {
  std::vector<std::vector<std::pair<std::string, std::string>>> rows;
  std::vector<std::string> columns;
  for (const SweepCase& c : cases) {
    rows.push_back(row_of(folder, c));
    for (const auto& [name, unused] : rows.back())
      if (std::find(columns.begin(), columns.end(), name) == columns.end()) columns.push_back(name);
  }
  std::string text;
  for (std::size_t i = 0; i < columns.size(); ++i) text += (i ? "," : "") + csv_cell(columns[i]);
  text += "\n";
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto cell = std::find_if(row.begin(), row.end(), [&](const auto& c) { return c.first == columns[i]; });
      text += (i ? "," : "") + (cell == row.end() ? "" : csv_cell(cell->second));
    }
    text += "\n";
  }
  return text;
}

}  // namespace brim::cli
