#include "brim/world/touch_rules.h"

#include <algorithm>
#include <cctype>

#include "brim/core/error.h"

namespace brim {

namespace {

/// Greedy match with * and ?; on failure backtracks to the last *.
bool matches_pattern(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, from = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++, from = n;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
      ++p, ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1, n = ++from;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

bool is_copy(std::string_view stem, std::string_view name) {
  if (name.size() < stem.size() + 2 || !name.starts_with(stem) || name[stem.size()] != '.') return false;
  const std::string_view number = name.substr(stem.size() + 1);
  return std::all_of(number.begin(), number.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

}  // namespace

bool name_matches(std::string_view wanted, std::string_view name) {
  return wanted == name || is_copy(wanted, name) || matches_pattern(wanted, name);
}

void TouchRules::add(const TouchRule& rule, int region) {
  const auto is_void = [&](const TouchRule& r) { return r.overruled_by(rule); };
  if (rules_.size() - static_cast<std::size_t>(std::ranges::count_if(rules_, is_void)) >= kMost)
    throw InputError(fmt::format("rules of which bodies touch: at most {} are allowed", kMost));
  std::size_t kept = 0;
  for (std::size_t i = 0; i < rules_.size(); ++i)
    if (!is_void(rules_[i])) rules_[kept] = rules_[i], regions_[kept++] = regions_[i];
  rules_.resize(kept), regions_.resize(kept);
  rules_.push_back(rule);
  regions_.push_back(region);
  about_parts_ = 0;
  for (std::size_t i = 0; i < rules_.size(); ++i)
    if (rules_[i].about_part() || regions_[i] >= 0) about_parts_ |= std::uint64_t{1} << i;
}

bool TouchRules::touch_somewhere(std::uint64_t about) const {
  for (std::uint64_t left = about; left != 0;) {
    const std::size_t i = last_of(left);
    const std::uint64_t bit = std::uint64_t{1} << i;
    if (rules_[i].touch || (about_parts_ & bit) == 0) return rules_[i].touch;
    left &= ~bit;
  }
  return true;
}

TouchRules::Sides TouchRules::sides(std::string_view name) const {
  Sides s;
  for (std::size_t i = 0; i < rules_.size(); ++i) {
    if (name_matches(rules_[i].a, name)) s.a |= std::uint64_t{1} << i;
    if (name_matches(rules_[i].b, name)) s.b |= std::uint64_t{1} << i;
  }
  return s;
}

}  // namespace brim
