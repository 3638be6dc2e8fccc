#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "brim/record/ragged_list.h"
#include "brim/world/step_report.h"
#include "brim/world/world.h"

namespace brim {

/// Lists of a run whose length varies from frame to frame: contacts, tiles, pairs, attachments, the memory of the
/// state, warnings (docs/formats.md).
/// Tests: tests/record/run_test.cpp
class FrameLists {
 public:
  FrameLists() = default;
  FrameLists(h5::File& file, const World& world, bool create);

  /// Adds the lists of a frame. @param contacts, tiles  the world's own, or those of a copied run
  void add(const World& world, const StepReport& frame, std::span<const ContactSample> contacts,
           std::span<const std::pair<TileKey, double>> tiles);
  /// Drops all frames from `frames` on.
  void cut(std::uint64_t frames);
  void flush();

 private:
  void add_contacts(std::span<const ContactSample> list);
  void add_tiles(std::span<const std::pair<TileKey, double>> list);
  void add_pairs(const std::vector<PairReport>& list);
  void add_links(const std::vector<LinkReport>& list);
  void add_link_ends(const World& world);
  void add_warnings(const std::vector<Warning>& list);
  template <class Visit>
  void for_each(const Visit& visit);

  RaggedList contacts_, tiles_, pairs_, memory_, warnings_;
  std::optional<RaggedList> links_, link_ends_;  ///< of worlds with attachments
};

}  // namespace brim
