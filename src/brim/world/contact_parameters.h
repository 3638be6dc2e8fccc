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

/// True when the part cannot deform: its body has no more velocities than its parts would have as rigid bodies.
bool is_rigid(const WorldPart& p);

/// True when the distance to the part is known.
bool has_distance(const WorldPart& p);

/// The response of a pair for which neither materials nor bodies set one: the world's, or, where it leaves it open
/// (Response::Inherit), rows between two solids if no stiffness is given, else penalties.
Response default_response(const WorldPart& a, const WorldPart& b, const WorldOptions& options);

/// True when constraint rows act between the parts: their contacts are found before they touch, wherever the grid nodes
/// lie.
bool meet_by_rows(const WorldPart& a, const WorldPart& b, const WorldOptions& options);
/// True when rows act between the parts and neither can deform.
bool meet_by_rigid_rows(const WorldPart& a, const WorldPart& b, const WorldOptions& options);

/// Contact parameters of two parts, from the scene, their materials and the loads.
/// Tests: tests/world/contact_parameters_test.cpp, tests/world/loads_test.cpp
class ContactParameters {
 public:
  /// Estimates the loads, and the world's largest stiffness, from the initial state.
  /// @param v   [m/s] velocities of all bodies  @param h0  [m] finest step of the grid
  void start(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
             const WorldOptions& options, double h0);
  /// [Pa] the largest of all pairs without a stiffness of their own
  double stiffness() const { return stiffness_; }

  /// Sets the responses' parameters of every pair of a sub-step's contacts, at the velocities v.
  void choose(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
              const WorldOptions& options, const ContactStage& stage);
  /// The last pairs, from `first` on, are links: they get no contact parameters, and hold the bodies that they join.
  void leave_to_links(std::span<const WorldPart> parts, const ContactSet& contacts, std::size_t first);
  /// Warns of materials whose given contact stiffness is below five times the modulus of the material behind it, or
  /// thirty times what would be chosen, and of restitutions of pairs that meet by penalties.
  void warn(std::span<const WorldPart> parts, const WorldOptions& options, StepReport& report) const;
  /// Parameters of constraint rows between two parts.
  ConstraintPair constraint_between(const WorldPart& a, const WorldPart& b, const WorldOptions& options) const;
  /// Parameters of a pair of materials; stiffness 0 when it is to be chosen from the loads.
  PairMaterial material_of(const WorldPart& a, const WorldPart& b, const WorldOptions& options) const;
  std::span<const PairState> penalties() const { return penalties_; }
  std::span<const ConstraintPair> constraints() const { return constraints_; }

 private:
  /// Warns of restitutions given to deformable bodies, or to pairs with them, that meet others by penalties.
  void warn_of_restitution(std::span<const WorldPart> parts, const WorldOptions& options, StepReport& report) const;
  /// [Pa] required by the loads between two parts
  double stiffness_under(const Loads& loads, const PartInfo& a, const PartInfo& b, double dt) const;
  /// [Pa] of a pair without a given stiffness, in this sub-step
  double chosen_stiffness(const WorldPart& a, const WorldPart& b, double dt) const;
  /// [-] PairState::growth of a pair whose stiffness was chosen: up to what the lighter body bears by its own weight
  /// where one part is a sheet (modulus 0), else 1. The chosen stiffness spreads a body's weight over its footprint,
  /// but a membrane gathers it on an edge. Matter with a modulus E bears no pressure much above E, and its contact has
  /// 20 E.
  double growth_of(const WorldPart& a, const WorldPart& b, double stiffness, const WorldOptions& options) const;

  double stiffness_ = 0.0;
  Loads heaviest_;  ///< of the whole world
  LoadGroups groups_;
  double loads_width_ = 0.0;  ///< [m] ramp that the stiffness was chosen for
  std::vector<PairState> penalties_;
  std::vector<ConstraintPair> constraints_;
};

}  // namespace brim
