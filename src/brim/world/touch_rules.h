#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Rule whether bodies of two names touch. In a name * stands for any characters and ? for one; the stem of numbered
/// copies ("box" for box.0, box.1, ...) stands for all of them. A name that no body has is about those added later.
/// With a region the rule applies only to contacts on that part of a body: on the material that was there when rule and
/// body first both existed.
struct TouchRule {
  std::string a, b;
  bool touch = false;
  std::function<bool(const Vec3&)> region_a{}, region_b{};  ///< [m] of places; empty: the whole body

  bool about_part() const { return region_a || region_b; }
  /// True when a later rule makes this one void: it is about all of the bodies of the same two names.
  bool overruled_by(const TouchRule& later) const {
    return !later.about_part() && ((a == later.a && b == later.b) || (a == later.b && b == later.a));
  }
};

/// True when `wanted` is the name, a stem of it or a pattern of it (TouchRule).
bool name_matches(std::string_view wanted, std::string_view name);

/// Decides which bodies touch: by rules on names, of which the last one about a pair wins, and by pairs of bodies that
/// links keep from touching. Pairs without a rule touch. A test takes a few instructions. If rules concern parts of
/// bodies, the last one about a contact wins, which PartFilter evaluates.
/// Tests: tests/world/touch_rules_test.cpp
class TouchRules {
 public:
  static constexpr std::size_t kMost = 64;
  /// The rules that name a body on either side, as bits.
  struct Sides {
    std::uint64_t a = 0, b = 0;
  };

  /// @param region  the caller's number for the rule's regions, if any
  /// @throws InputError for more than kMost rules
  void add(const TouchRule& rule, int region = -1);
  Sides sides(std::string_view name) const;
  /// Keeps two bodies from touching, whatever the rules say.
  void keep_apart(int body_a, int body_b) { apart_.insert(std::minmax(body_a, body_b)); }
  void clear_apart() { apart_.clear(); }

  bool touch(const Sides& x, int body_x, const Sides& y, int body_y) const {
    if (!apart_.empty() && apart_.contains(std::minmax(body_x, body_y))) return false;
    const std::uint64_t about = (x.a & y.b) | (x.b & y.a);
    if ((about & about_parts_) != 0) return touch_somewhere(about);
    return about == 0 || rules_[last_of(about)].touch;
  }

  /// The rules about parts of two bodies that follow the last one about the whole pair, as bits.
  std::uint64_t about_parts(const Sides& x, const Sides& y) const {
    const std::uint64_t about = (x.a & y.b) | (x.b & y.a), whole = about & ~about_parts_;
    if ((about & about_parts_) == 0) return 0;
    return whole == 0 ? about : about & about_parts_ & ~((std::uint64_t{2} << last_of(whole)) - 1);
  }
  /// True when a contact of two bodies counts.
  /// @param inside  (region, exchanged): true when the contact lies in both regions of a rule, with body x on its side
  ///                a, or on side b if exchanged
  template <class Inside>
  bool touch_there(const Sides& x, const Sides& y, const Inside& inside) const {
    for (std::uint64_t left = (x.a & y.b) | (x.b & y.a); left != 0;) {
      const std::size_t i = last_of(left);
      const std::uint64_t bit = std::uint64_t{1} << i;
      if ((about_parts_ & bit) == 0 || (((x.a & y.b) & bit) != 0 && inside(regions_[i], false)) ||
          (((x.b & y.a) & bit) != 0 && inside(regions_[i], true)))
        return rules_[i].touch;
      left &= ~bit;
    }
    return true;
  }

 private:
  static std::size_t last_of(std::uint64_t bits) { return 63 - static_cast<std::size_t>(std::countl_zero(bits)); }
  bool touch_somewhere(std::uint64_t about) const;

  std::vector<TouchRule> rules_;
  std::vector<int> regions_;  ///< per rule
  std::uint64_t about_parts_ = 0;
  std::set<std::pair<int, int>> apart_;
};

}  // namespace brim
