#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "brim/grid/tile.h"
#include "brim/math/types.h"

namespace brim {

/// Where the time of a step goes (design: one step).
enum class Phase { Presence, Refine, Rasterize, Detect, Respond, Solve, SolveContact, Advance, Record, Count };
inline constexpr std::array<const char*, static_cast<std::size_t>(Phase::Count)> kPhaseNames = {
    "presence", "refine", "rasterize", "detect", "respond", "solve", "solve_contact", "advance", "record"};

/// Totals of one touching pair of parts. Index i of a part is a global part number (World::part).
struct PairReport {
  std::int32_t part_a = 0, part_b = 0;
  std::int32_t contacts = 0;          ///< nodes
  double worst_overlap = 0.0;         ///< [voxels of the pair]
  double worst_pressure = 0.0;        ///< [-] fraction of k, saturates near 0.5
  Vec3 force_on_a = Vec3::Zero();     ///< [N] normal and friction
  Vec3 friction_on_a = Vec3::Zero();  ///< [N] friction alone
  Vec3 center = Vec3::Zero();         ///< [m] centre of pressure
};

/// An attachment or joint in the last sub-step (World::attachment).
struct LinkReport {
  Vec3 force = Vec3::Zero();  ///< [N] on its first body, in all: held points, drive and limits
  double error = 0.0;         ///< [m] largest position error of its points
  double coordinate = 0.0;    ///< [rad or m] of a revolute or prismatic joint, at the start of the sub-step
  double effort = 0.0;        ///< [N m or N] drive, spring and limits along the coordinate, on the first body
  bool broken = false;
};

/// Number of warnings in a report from which on pairs and links add no more: in a crowd thousands would say the same.
inline constexpr std::size_t kMostWarnings = 16;

/// A problem or near-problem, in words, with the pair or body it concerns.
struct Warning {
  double time = 0.0;  ///< [s]
  std::string code;   ///< "saturation", "no_convergence", "not_finite", "substeps_capped", ...
  std::string message;
};

/// One contact node, for records and viewers.
struct ContactSample {
  Vec3f position;  ///< [m]
  Vec3f force;     ///< [N] on a, normal
  Vec3f friction;  ///< [N] on a
  float overlap;   ///< [voxels]
  std::int32_t part_a, part_b;
};

/// Report of one step of the world (a frame may consist of several).
struct StepReport {
  double time = 0.0;  ///< [s] at the end of the step
  double dt = 0.0;    ///< [s]
  int substeps = 0;
  bool ok = true;  ///< false: the solve failed; the state is that before the failed sub-step
  std::array<double, static_cast<std::size_t>(Phase::Count)> seconds{};  ///< wall time per phase
  double& seconds_of(Phase p) { return seconds[static_cast<std::size_t>(p)]; }
  double wall = 0.0;               ///< [s] whole step
  std::int64_t tiles_present = 0;  ///< coarse: tiles marked by some part; like all counts summed over sub-steps
  std::int64_t tiles = 0;  ///< tiles rasterized, and cubes of up to 6x6x6 nodes in which solids were sampled, per part
  std::int64_t voxels =
      0;  ///< nodes sampled: for rasterized parts those of the searched octants, for solids those needed
  std::int64_t contacts = 0;  ///< of the last sub-step
  int cg_iterations = 0;      ///< summed over the solves
  int solves = 0;
  int sweeps = 0;              ///< of projected Gauss-Seidel over the constraint rows, summed
  double row_residual = 0.0;   ///< relative, worst: change by the last correction of the rows
  double cg_residual = 0.0;    ///< relative, worst
  double worst_overlap = 0.0;  ///< [voxels], worst over sub-steps
  double kinetic_energy = 0.0, potential_energy = 0.0, contact_energy = 0.0;  ///< [J]
  double momentum_error = 0.0;    ///< [-] worst body: mapped contact force minus the sum of its nodal forces
  double angular_error = 0.0;     ///< [-] likewise for the torque about the body's centre of contact
  double max_speed = 0.0;         ///< [m/s] upper bound over movable parts
  int asleep = 0;                 ///< bodies that sleep at the end of the step
  double stiffness = 0.0;         ///< [Pa] World::stiffness
  std::vector<Vec3> impulse;      ///< [N s] of the contacts on each body, summed; shape (bodies), or empty
  std::vector<PairReport> pairs;  ///< of the last sub-step, ordered by part numbers
  std::vector<LinkReport> links;  ///< of the last sub-step, one per attachment
  std::vector<Warning> warnings;
};

}  // namespace brim
