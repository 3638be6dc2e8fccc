#pragma once

#include <span>
#include <vector>

#include "brim/world/contact_stage.h"

namespace brim {

/// The loads that one or several parts put on their contacts, estimated from the initial state.
struct Loads {
  double pressure = 0.0;    ///< [Pa] largest weight per area of the part and what lies above, in a column along gravity
  double areal_mass = 0.0;  ///< [kg/m²] largest mass of one part over its footprint
  double impact_energy = 0.0;  ///< [J/m²] largest areal mass times squared speed at impact

  /// Component-wise maximum with other.
  void raise_to(const Loads& other);
};

/// [m/s²] Pull for which the contact of sheets is chosen: gravity, and where there is little of it that of the Earth. A
/// sheet pressed by a body moved from outside carries far more than its mass tells, and is let through at the 20 Pa
/// that the length of a step asks for.
constexpr double kLeastPull = 9.81;
double sheet_pull(const Environment& env);

/// @param part_speed  [m/s] shape (parts)
/// @return the loads of each part; zero for fixed parts
std::vector<Loads> estimate_loads(std::span<const WorldPart> parts, std::span<const double> part_speed,
                                  const Environment& env);

/// Contact stiffness required by the loads between parts that do not deform, [Pa]: the largest of
///   2000 p_max                  static loads: penetration of 3.3 p/k voxels, stacks that stand
///   8 ρL v² / w                 impacts stop within about a voxel
///   4 ρL w / (1.2 dt²)          the implicit step cannot resolve softer contact
double choose_stiffness(const Loads& loads, double w, double dt);

/// Largest stiffness of contact with stiff material over k, where impacts move by a voxel or more in a step, and where
/// they move by a quarter of one or less; between the two it falls with the square of the motion. Nodes that are not
/// foreseen before they overlap bring energy in, up to k h/2 per area at one voxel: bars of 1e8 Pa and of steel dropped
/// by 0.5 m at steps of 1/60 s left the floor at 600 and 2,400 m/s at 20 E; they come to rest at 300 k and less. Balls
/// of 2e6 Pa pressed by hand need 450 k for 20 E.
constexpr double kMostOfFast = 30.0, kMostOfSlow = 500.0;

/// Contact stiffness of a pair whose softer side has the Young's modulus E, [Pa]: k if neither deforms (E infinite),
/// else
///   max(min(20 E, s k), 100 p_max, 8 ρL v² / w, 4 ρL w / (1.2 dt²))
/// with s from kMostOfFast to kMostOfSlow.
/// The contact layer is in series with the material behind it and compresses by δ = p w/(1.2 c² k), c = 0.87: share of
/// the ramp's slope seen by the stencil. For a patch of radius a on a body of radius R, indented by a²/R with Hertz's
/// mean pressure p = 4 E a/(3π (1 − ν²) R), and w = 3h,
///   δ/(a²/R) = 1.5 (E/k) (h/a)   and the force is lower by 3/2 of that:
/// 11 % for a patch one voxel wide and less for wider ones, independent of the load (a body moved by hand has no weight
/// to estimate from). At 40 E and more the slip of a body spreading on a floor is not found in max_passes solves. Only
/// stiff bodies stacked high need all of k. Below kTellingModulus times E the contact layer, not the bodies, takes most
/// of the compression.
constexpr double kContactModulus = 20.0;
constexpr double kTellingModulus = 5.0;
double soften_stiffness(double k, double E, const Loads& loads, double w, double dt);

/// Contact stiffness of conforming parts (PartInfo::conforming), [Pa]: 20 E, between 20 and 1000 p_max, at most k (k
/// without weight). E is the modulus of the conforming side, 0 when its surface is only as accurate as its own grid: at
/// 1000 p_max a hundredth of a voxel of such noise presses ten times as hard as the weight and stirs the fluid. A
/// conforming part yields to impacts, so its whole depth need not stop within a voxel. Particles need the stiff value:
/// at 100 p_max a solve takes half the iterations, but a small inviscid pool bounces in its basin for seconds.
double conforming_stiffness(double k, double E, const Loads& loads);

}  // namespace brim
