#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "brim/body/body.h"
#include "brim/contact/contact_set.h"
#include "brim/world/step_report.h"
#include "brim/world/world.h"

namespace brim {

/// A part as the world numbers it.
struct WorldPart {
  const Body* body = nullptr;
  int body_index = 0;
  int index = 0;   ///< within the body
  double h = 0.0;  ///< [m] its own grid step, h0 2^l
  PartInfo info;
};

/// False for pairs that are never looked at: nothing moves, or their body says that they do not touch.
inline bool may_touch(const WorldPart& a, const WorldPart& b) {
  if (a.body == b.body && !a.body->parts_collide(a.index, b.index)) return false;
  return !(a.body->immobile() && b.body->immobile());
}

/// Presence, refinement, rasterization and detection for all parts of a world (paper, section 6).
/// Memory is kept from step to step.
class ContactStage {
 public:
  /// @throws InputError when the density blocks would need more memory than the limit
  void find(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
            double dt, const WorldOptions& options, StepReport& report);

  const ContactSet& contacts() const { return contacts_; }
  std::span<const std::pair<TileKey, double>> active_tiles() const { return active_; }

 private:
  /// One part at one grid step: the unit of rasterization.
  struct Layer {
    std::int32_t part = 0;
    double h = 0.0;
    Aabb region;                   ///< where some other part may be
    std::vector<TileKey> present;  ///< tiles that may hold density, sorted
    std::vector<TileKey> needed;   ///< tiles on which a pair meets, sorted
    std::vector<Octants> octants;  ///< of those, where some pair may have contacts
    std::size_t first_block = 0;
  };
  struct Candidate {
    std::int32_t pair_layer_a = 0, pair_layer_b = 0;
    ContactPair pair;
    Aabb region;
    std::vector<TileKey> tiles;
    std::vector<Octants> octants;  ///< of each tile
  };

  void find_candidates(std::span<const WorldPart> parts, std::span<const double> v,
                       std::span<const std::size_t> first_v, double dt, const WorldOptions& options);
  std::int32_t layer_of(std::int32_t part, double h, const Aabb& region);
  void find_presence(std::span<const WorldPart> parts, double ramp, StepReport& report);
  void refine(std::span<const WorldPart> parts, const WorldOptions& options);
  void rasterize(std::span<const WorldPart> parts, double ramp, StepReport& report);
  void collect();

  std::vector<Layer> layers_;
  std::vector<Candidate> candidates_;
  std::size_t layer_count_ = 0, candidate_count_ = 0;
  std::vector<DensityBlock> blocks_;
  std::vector<PairTile> pair_tiles_;
  std::vector<std::pair<TileKey, double>> active_;
  ContactSet contacts_;
};

}  // namespace brim
