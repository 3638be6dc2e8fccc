#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/world/start_places.h"
#include "brim/world/touch_rules.h"
#include "brim/world/world_part.h"

namespace brim {

/// Leaves out the contacts that rules about parts of bodies keep from touching. A contact is left out for both sides or
/// for none, so that momentum is kept as without rules. What counts is where the matter at the contact was at the start
/// (StartPlaces). Same bits for any number of threads.  Tests: tests/world/part_filter_test.cpp
class PartFilter {
 public:
  /// Takes a rule with regions in. @return what TouchRules::add is to be told
  int add(const TouchRule& rule);
  const TouchRule& rule(int region) const { return rules_[static_cast<std::size_t>(region)]; }
  int size() const { return static_cast<int>(rules_.size()); }
  /// Remembers where the matter of bodies is that rules have not met yet.
  /// @throws InputError for bodies that carry no region along
  void meet(std::span<const std::unique_ptr<Body>> bodies);
  /// Says whether such rules are about two parts.
  static bool concerns(const WorldPart& a, const WorldPart& b) {
    return a.rules != nullptr && a.rules->about_parts(a.sides, b.sides) != 0;
  }
  /// The bodies have moved.
  void moved();
  /// Whether the contact of two parts at x counts; call follow before where many threads ask.
  bool touch(const WorldPart& a, const WorldPart& b, const Vec3& x);
  void follow(const WorldPart& part);
  /// False where rules keep all matter of two parts from touching, as far as the corners and the middle of the smaller
  /// one's box tell.
  bool leaves_some(const WorldPart& a, const WorldPart& b);
  /// Takes what does not count out of a set without links.
  void apply(std::span<const WorldPart> parts, ContactSet& set);

 private:
  bool in_region(int region, bool side_b, const WorldPart& part, const Vec3& x);

  std::vector<TouchRule> rules_;
  std::map<std::pair<int, int>, std::shared_ptr<StartPlaces>> places_;  ///< by region and body
  std::vector<std::uint8_t> counts_;
};

}  // namespace brim
