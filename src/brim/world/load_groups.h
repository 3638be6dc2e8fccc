#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "brim/world/contact_stage.h"
#include "brim/world/loads.h"
#include "brim/world/world_part.h"

namespace brim {

/// The loads that a contact may have to carry: those of all bodies that can press on it.
///
/// What touches or is linked passes loads on, so that a contact carries the heaviest of the bodies that are joined to
/// it; what is fixed joins nothing, and what lies elsewhere in the world does not count. A body that rests on the
/// others by one contact alone, with all that rests on it, presses on it by its own loads, and counts with at most ten
/// times these, however heavy the others:
///
///        c       c, b on d; a beside them     contact   carries the heaviest of
///        b       all on the floor f           c b       b, c, d, or ten times c
///    a   d                                    b d       b, c, d, or ten times b, c
///   ‾‾‾‾‾‾‾‾ f                                d f       b, c, d
///                                             a f       a
///
/// Nothing rests so that is held elsewhere: by what is fixed, by nodes or a base of its own that are, or in a fluid;
/// nor what two parts of another body have between them. Such a contact is a bridge of the graph of bodies (Tarjan
/// 1974). The groups are those of the sub-step's contacts and links: a state that is set or resumed has the same. Cost
/// O(n log n) in contacts of pairs.  Tests: tests/world/load_groups_test.cpp
class LoadGroups {
 public:
  /// @param loads  of each part, at the start
  void start(std::span<const WorldPart> parts, std::span<const Loads> loads);
  /// Finds the groups of a sub-step, once its contacts and links are known.
  void find(std::span<const WorldPart> parts, const ContactStage& stage);
  /// What the contact of two parts carries, of which one can move.
  const Loads& between(const WorldPart& a, const WorldPart& b) const;
  /// What the body of a part puts on its contacts by itself.
  const Loads& own(const WorldPart& p) const { return own_[static_cast<std::size_t>(p.body_index)]; }

 private:
  void touch(const WorldPart& a, const WorldPart& b);
  /// Numbers all bodies that the root reaches, depth first.
  void visit(std::int32_t root);
  void share();

  std::vector<Loads> own_;                                    ///< per body, at the start
  std::vector<std::uint8_t> pinned_;                          ///< per body: cannot move as a whole
  std::vector<std::pair<std::int32_t, std::int32_t>> edges_;  ///< bodies that touch, both ways, ascending
  std::vector<std::size_t> first_edge_;                       ///< per body, and the end
  std::vector<std::uint8_t> held_;                            ///< per body; once shared, or what rests on it
  std::vector<std::int32_t> visited_;                         ///< bodies in the order of visits
  std::vector<std::int32_t> order_, parent_;                  ///< per body
  std::vector<Loads> carried_;                                ///< per body
};

}  // namespace brim
