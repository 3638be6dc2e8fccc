#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "brim/body/body.h"
#include "brim/body/octant_presence.h"
#include "brim/contact/cube_contacts.h"
#include "brim/math/box_sweep.h"
#include "brim/world/held_pairs.h"
#include "brim/world/rigid_contacts.h"
#include "brim/world/step_report.h"
#include "brim/world/tile_culling.h"
#include "brim/world/world.h"
#include "brim/world/world_part.h"

namespace brim {

/// [voxels] by which places of contact are searched farther, for the rounding of densities.
inline constexpr double kDensityRounding = 1e-3;

/// Finds the contacts of all parts of a world (paper, section 6). Solids are sampled pair by pair, only at the nodes
/// that a contact needs. Other parts are rasterized tile by tile, once for all their pairs: presence, refinement,
/// rasterization. Memory is kept from step to step.
class ContactStage {
 public:
  /// @param held_before  pairs that rows connected in the last sub-step
  /// @throws InputError when the density blocks would need more memory than the limit
  void find(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
            double dt, const HeldPairs& held_before, const WorldOptions& options, StepReport& report);

  /// True: coarse densities are means of fine ones; false: samples.
  void average(bool means) { average_ = means; }
  /// Contacts of all pairs except those in rigid().
  const ContactSet& contacts() const { return contacts_; }
  /// The same, for another search to add to.
  ContactSet& contacts() { return contacts_; }
  /// A part as a solid with its pose, or null.
  const CubeSide* solid(std::int32_t part) const { return access_[part].is_solid() ? &access_[part].solid : nullptr; }
  /// Pairs of rigid solids held by rows; empty until started.
  RigidContacts& rigid() { return rigid_; }
  const RigidContacts& rigid() const { return rigid_; }
  /// Calls f(part_a, part_b) for pairs of which both parts were sampled in some place, with contacts or not: they are
  /// within a few voxels of each other. A pair may occur more than once.
  template <class F>
  void for_near(const F& f) const {
    for (std::size_t i = 0; i < work_count_; ++i) {
      const Candidate& c = candidates_[work_[i].candidate];
      if (work_[i].begin < work_[i].end || work_[i].finds.nodes > 0) f(c.pair.part_a, c.pair.part_b);
    }
    rigid_.for_near(f);
  }
  /// Tiles in which both parts of some pair were sampled, and their steps.
  std::span<const std::pair<TileKey, double>> active_tiles() const;
  /// Clears the active tiles, which belong to another state.
  void forget() { active_.clear(), active_known_ = true; }

 private:
  /// Optional interfaces of a part besides rasterization.
  struct PartAccess {
    BoundedPart bounded;
    CubeSide solid;                     ///< of solids
    const PosedShape* posed = nullptr;  ///< the solid
    bool immobile = false;
    bool is_solid() const { return solid.solid != nullptr; }
  };
  /// One part that is rasterized, at one grid step.
  struct Layer {
    std::int32_t part = 0;
    double h = 0.0;
    int level = 0;                    ///< level of detail
    Aabb region;                      ///< [m] box in which other parts may be
    std::vector<OctantTile> present;  ///< tiles that may hold density, with their octants; sorted
    std::vector<TileKey> needed;      ///< tiles that some pair shares, sorted
    std::vector<Octants> octants;     ///< of the needed tiles: octants that may hold contacts of some pair
    std::size_t first_block = 0;
  };
  /// Extent and motion of a part, for the broad phase.
  struct Outline {
    Aabb box;    ///< [m] at present, ramp included
    Aabb swept;  ///< [m] union of the box now and at its reference, for rigid solids that rows may hold
    Vec3 velocity = Vec3::Zero();
    double spread = 0.0;  ///< [m/s] bound of the speed relative to `velocity`
  };
  /// Treatment of two parts whose boxes overlap.
  struct Meeting {
    enum How : std::uint8_t { kNot, kHeld, kSearched };  ///< held by RigidContacts, or searched on the grid
    How how = kNot;
    int level = 0;
    double h = 0.0, margin = 0.0;
    Aabb region;
  };
  struct Candidate {
    std::int32_t layer_a = -1, layer_b = -1;  ///< of the sides that are not solids
    ContactPair pair;
    int level = 0;  ///< level at which the two meet
    /// One conforms to the other and its density is a volume fraction, so the other's is averaged too.
    bool averaged = false;
    bool by_part = false;  ///< rules concern parts of the two bodies, so they may lie inside each other
    Aabb region;
    std::vector<TileKey> tiles;    ///< of pairs with a layer
    std::vector<Octants> octants;  ///< of each tile
  };
  /// A piece of a candidate's search: all of it between two solids, else some of its tiles.
  struct Work {
    std::size_t candidate = 0, begin = 0, end = 0;
    CubeFinds finds;
    double roundness = 1.0;  ///< ContactPair::roundness
  };

  /// @throws InputError  naming the quantity that exceeds the memory limit, and the limit [bytes]
  [[noreturn]] static void refuse_crowd(const char* what, double most, double limit);
  void access(std::span<const WorldPart> parts);
  void find_candidates(std::span<const WorldPart> parts, std::span<const double> v,
                       std::span<const std::size_t> first_v, double dt, const HeldPairs& held_before,
                       const WorldOptions& options);
  void outline(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
               double ramp);
  /// Pairs of parts whose swept boxes overlap, ordered.
  void sweep_boxes(double memory_limit);
  /// [m/s] bound of the relative speed of the material of two parts.
  double largest_speed(std::int32_t a, std::int32_t b) const;
  /// Finds how fast each part that deforms may be hit.
  void find_blows(std::span<const WorldPart> parts);
  Meeting meet(std::span<const WorldPart> parts, std::int32_t a, std::int32_t b, double dt,
               const HeldPairs& held_before, const WorldOptions& options) const;
  std::int32_t layer_of(std::int32_t part, double h, int level, const Aabb& region);
  /// A solid as seen by a candidate: averaged on coarse levels.
  CubeSide side_of(std::int32_t part, const Candidate& c) const;
  void find_presence(std::span<const WorldPart> parts, double ramp, StepReport& report);
  void refine(const WorldOptions& options);
  void rasterize(std::span<const WorldPart> parts, double ramp, StepReport& report);
  void plan_work();
  void search(Work& work) const;
  void collect(StepReport& report);

  RigidContacts rigid_;
  bool average_ = true;  ///< coarse densities are means of fine ones
  std::vector<RigidContacts::Touch> held_;
  std::vector<Outline> outline_;  ///< per part
  /// [m/s] per part that deforms: largest speed of another near it relative to it; 0 for all else, and of fluids.
  std::vector<double> blow_;
  std::vector<Aabb> swept_;  ///< of each part
  BoxSweep sweep_;
  std::vector<std::int32_t> first_touch_;
  std::vector<std::vector<std::pair<std::int32_t, std::int32_t>>>
      near_;  ///< in the lists of the blocks of boxes that found them
  std::vector<std::pair<std::int32_t, std::int32_t>> touching_;
  std::vector<Meeting> meeting_;    ///< per entry of touching_
  std::vector<PartAccess> access_;  ///< per part
  std::vector<Layer> layers_;
  std::vector<Candidate> candidates_;
  std::vector<Work> work_;
  std::size_t layer_count_ = 0, candidate_count_ = 0, work_count_ = 0;
  std::vector<DensityBlock> blocks_;
  std::vector<PairFinds> pieces_;
  ContactSet contacts_;
  mutable std::vector<std::pair<TileKey, double>> active_;  ///< built on demand
  mutable bool active_known_ = false;
};

}  // namespace brim
