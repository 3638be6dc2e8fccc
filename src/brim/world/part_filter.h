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

/// Removes the contacts that rules about parts of bodies exclude. A contact is removed for both sides or for neither,
/// so momentum is conserved as without rules. The rule is evaluated at the start position of the material at the
/// contact (StartPlaces). Same bits for any number of threads.  Tests: tests/world/part_filter_test.cpp
class PartFilter {
 public:
  /// Adds a rule with regions. @return the number to pass to TouchRules::add
  int add(const TouchRule& rule);
  const TouchRule& rule(int region) const { return rules_[static_cast<std::size_t>(region)]; }
  int size() const { return static_cast<int>(rules_.size()); }
  /// Stores the material positions of bodies that are new to the rules.
  /// @throws InputError for bodies that cannot carry a region along
  void meet(std::span<const std::unique_ptr<Body>> bodies);
  /// True when rules about parts apply to the two parts.
  static bool concerns(const WorldPart& a, const WorldPart& b) {
    return a.rules != nullptr && a.rules->about_parts(a.sides, b.sides) != 0;
  }
  /// To be called when the bodies have moved.
  void moved();
  /// True when the contact of two parts at x counts; call follow first when many threads ask.
  bool touch(const WorldPart& a, const WorldPart& b, const Vec3& x);
  void follow(const WorldPart& part);
  /// False when rules exclude all contact of two parts, judged from the corners and the middle of the smaller one's
  /// box.
  bool leaves_some(const WorldPart& a, const WorldPart& b);
  /// Removes excluded contacts from a set without links.
  void apply(std::span<const WorldPart> parts, ContactSet& set);

 private:
  bool in_region(int region, bool side_b, const WorldPart& part, const Vec3& x);

  std::vector<TouchRule> rules_;
  std::map<std::pair<int, int>, std::shared_ptr<StartPlaces>> places_;  ///< by region and body
  std::vector<std::uint8_t> counts_;
};

}  // namespace brim
