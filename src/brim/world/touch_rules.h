#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace brim {

/// Says whether bodies of two names touch. A name may have * for any characters and ? for one; the stem of numbered
/// copies ("box" for box.0, box.1, ...) stands for all of them.
struct TouchRule {
  std::string a, b;
  bool touch = false;
};

/// True when `wanted` is the name, a stem of it or a pattern of it (TouchRule).
bool name_matches(std::string_view wanted, std::string_view name);

/// Which bodies touch: rules by name, of which the last one about a pair decides, and pairs of bodies that links keep
/// from touching. What no rule is about touches. A test is a few instructions.
/// Tests: tests/world/touch_rules_test.cpp
class TouchRules {
 public:
  static constexpr std::size_t kMost = 64;
  /// The rules that a body's name is on either side of, as bits.
  struct Sides {
    std::uint64_t a = 0, b = 0;
  };

  /// @throws InputError for more than kMost rules
  void add(const TouchRule& rule);
  Sides sides(std::string_view name) const;
  /// Two bodies never touch, whatever the rules say.
  void keep_apart(int body_a, int body_b) { apart_.insert(std::minmax(body_a, body_b)); }
  void clear_apart() { apart_.clear(); }

  bool touch(const Sides& x, int body_x, const Sides& y, int body_y) const {
    if (!apart_.empty() && apart_.contains(std::minmax(body_x, body_y))) return false;
    const std::uint64_t about = (x.a & y.b) | (x.b & y.a);
    return about == 0 || rules_[63 - static_cast<std::size_t>(std::countl_zero(about))].touch;
  }

 private:
  std::vector<TouchRule> rules_;
  std::set<std::pair<int, int>> apart_;
};

}  // namespace brim
