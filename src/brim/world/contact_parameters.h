#pragma once

#include <span>
#include <vector>

#include "brim/contact/contact_set.h"
#include "brim/response/constraint.h"
#include "brim/response/penalty.h"
#include "brim/world/contact_stage.h"
#include "brim/world/load_groups.h"
#include "brim/world/loads.h"
#include "brim/world/step_report.h"
#include "brim/world/world.h"

namespace brim {

/// True when the part cannot deform: its body has no more velocities than rigid parts would have.
bool is_rigid(const WorldPart& p);

/// True when constraint rows act between the parts: such contacts are found before they touch, wherever the nodes of
/// the grid lie.
bool meet_by_rows(const WorldPart& a, const WorldPart& b, const WorldOptions& options);
/// Of these, where neither can deform.
bool meet_by_rigid_rows(const WorldPart& a, const WorldPart& b, const WorldOptions& options);

/// The law of contact between two parts: what the scene, their materials and the loads say together.
/// Tests: tests/world/contact_parameters_test.cpp, tests/world/loads_test.cpp
class ContactParameters {
 public:
  /// Estimates the loads, and the stiffness that the world has at most, from its initial state.
  /// @param v   [m/s] velocities of all bodies  @param h0  [m] finest step of the grid
  void start(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
             const WorldOptions& options, double h0);
  /// [Pa] the largest of any pair that is not told its own
  double stiffness() const { return stiffness_; }

  /// What the responses need to know of every pair of a sub-step's contacts, at the velocities v.
  void choose(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
              const WorldOptions& options, const ContactStage& stage);
  /// The last pairs, from `first` on, are links: neither response has a law of its own for them.
  void leave_to_links(std::size_t first);
  /// Says of which materials the scene makes contact softer than five times the matter behind it, or thirty times
  /// stiffer than what would be chosen.
  void warn(std::span<const WorldPart> parts, const WorldOptions& options, StepReport& report) const;
  /// How rows would act between two parts.
  ConstraintPair constraint_between(const WorldPart& a, const WorldPart& b, const WorldOptions& options) const;
  /// What a pair of materials has; its stiffness is 0 where that is left to be chosen from the loads.
  PairMaterial material_of(const PartInfo& a, const PartInfo& b, const WorldOptions& options) const;
  std::span<const PairState> penalties() const { return penalties_; }
  std::span<const ConstraintPair> constraints() const { return constraints_; }

 private:
  /// [Pa] that loads ask for between two parts
  double stiffness_under(const Loads& loads, const PartInfo& a, const PartInfo& b, double dt) const;
  /// [Pa] of a pair for which the scene gives none, in this sub-step
  double chosen_stiffness(const WorldPart& a, const WorldPart& b, double dt) const;

  double stiffness_ = 0.0;
  Loads heaviest_;  ///< of the whole world
  LoadGroups groups_;
  double loads_width_ = 0.0;  ///< [m] ramp that the stiffness was chosen for
  std::vector<PairState> penalties_;
  std::vector<ConstraintPair> constraints_;
};

}  // namespace brim
