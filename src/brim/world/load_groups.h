#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "brim/world/contact_stage.h"
#include "brim/world/loads.h"
#include "brim/world/world_part.h"

namespace brim {

/// Loads that a contact may have to carry: those of all bodies that can press on it.
///
/// Contacts and links pass loads on: a contact carries the heaviest of the bodies connected to it. Fixed bodies connect
/// nothing, and unconnected bodies do not count. A body that rests on the others through a single contact, with all
/// that rests on it, presses on that contact by its own loads only; the contact then counts at most ten times these
/// loads, however heavy the others:
///
///        c       c, b on d; a beside them     contact   carries the heaviest of
///        b       all on the floor f           c b       b, c, d, or ten times c
///    a   d                                    b d       b, c, d, or ten times b, c
///   ‾‾‾‾‾‾‾‾ f                                d f       b, c, d
///                                             a f       a
///
/// This excludes bodies held elsewhere (by fixed bodies, by fixed nodes or a fixed base of their own, or in a fluid)
/// and bodies between two parts of another body. Such a contact is a bridge of the graph of bodies (Tarjan 1974). The
/// groups follow from the sub-step's contacts and links alone, so a state that is set or resumed gives the same. Cost
/// O(n log n) in contacts of pairs.  Tests: tests/world/load_groups_test.cpp
class LoadGroups {
 public:
  /// @param loads  of each part, at the start
  void start(std::span<const WorldPart> parts, std::span<const Loads> loads);
  /// Finds the groups of a sub-step, once its contacts and links are known.
  void find(std::span<const WorldPart> parts, const ContactStage& stage);
  /// Loads on the contact of two parts, one of which can move.
  const Loads& between(const WorldPart& a, const WorldPart& b) const;
  /// Loads that the body of a part alone puts on its contacts.
  const Loads& own(const WorldPart& p) const { return own_[static_cast<std::size_t>(p.body_index)]; }

 private:
  void touch(const WorldPart& a, const WorldPart& b);
  /// Numbers all bodies reachable from the root, depth first.
  void visit(std::int32_t root);
  void share();

  std::vector<Loads> own_;                                    ///< per body, at the start
  std::vector<std::uint8_t> pinned_;                          ///< per body: cannot move as a whole
  std::vector<std::pair<std::int32_t, std::int32_t>> edges_;  ///< bodies that touch, both ways, ascending
  std::vector<std::size_t> first_edge_;                       ///< per body, and the end
  std::vector<std::uint8_t> held_;            ///< per body: it is held; after share(), also if a body resting on it is
  std::vector<std::int32_t> visited_;         ///< bodies in the order of visits
  std::vector<std::int32_t> order_, parent_;  ///< per body
  std::vector<Loads> carried_;                ///< per body
};

}  // namespace brim
