#pragma once

#include <span>
#include <vector>

#include "brim/world/contact_stage.h"

namespace brim {

/// The loads that a part, or several, put on their contacts, estimated from the initial state.
struct Loads {
  double pressure = 0.0;       ///< [Pa] largest weight per area of it and what lies above, in a column along gravity
  double areal_mass = 0.0;     ///< [kg/m²] largest mass of one part over its footprint
  double impact_energy = 0.0;  ///< [J/m²] largest areal mass times squared speed at impact

  /// Becomes the larger of both, one by one.
  void raise_to(const Loads& other);
};

/// @param part_speed  [m/s] shape (parts)
/// @return the loads of each part; what is fixed has none
std::vector<Loads> estimate_loads(std::span<const WorldPart> parts, std::span<const double> part_speed,
                                  const Environment& env);

/// Contact stiffness that the loads ask for between parts that do not deform, [Pa]: the largest of
///   2000 p_max                  static loads: penetration of 3.3 p/k voxels, stacks that stand
///   8 ρL v² / w                 impacts stop within about a voxel
///   4 ρL w / (1.2 dt²)          the implicit step resolves no softer contact than this
double choose_stiffness(const Loads& loads, double w, double dt);

/// Contact stiffness of a pair whose softer side has the Young's modulus E, [Pa]: k where neither deforms (E infinite),
/// else
///   max(20 E, 100 p_max, 8 ρL v² / w, 4 ρL w / (1.2 dt²))
/// Contact is a layer in series with the matter behind it, and yields δ = p w/(1.2 c² k), c = 0.87 the share of the
/// ramp's slope that the stencil reads. Under a patch of radius a on what is as round as R, pressed in by a²/R with
/// Hertz's mean pressure p = 4 E a/(3π (1 − ν²) R), that is, with w = 3h,
///   δ/(a²/R) = 1.5 (E/k) (h/a)   and takes 3/2 of it from the force:
/// 11 % where the patch is one voxel wide and less where it is wider, whoever presses (what moves by hand has no weight
/// that would tell). At 40 E and more the slip of what spreads on a floor is not found in max_passes solves. Only stiff
/// bodies stacked high need all of k. Softer than kTellingModulus times E it is no longer the bodies that give.
constexpr double kContactModulus = 20.0;
constexpr double kTellingModulus = 5.0;
double soften_stiffness(double k, double E, const Loads& loads, double w, double dt);

/// Contact stiffness of what is conforming (PartInfo::conforming), [Pa]: 20 E, between 20 and 1000 p_max, at most k (k
/// without weight), E the modulus of the conforming side, which is 0 where its surface is only as good as its own grid:
/// at 1000 p_max a hundredth of a voxel of such noise presses ten times as hard as the weight, and stirs the fluid. It
/// gives way to a blow, so that nothing has to stop its whole depth within a voxel. Particles want it stiff: at
/// 100 p_max a solve takes half the iterations, but a small pool without viscosity bounces in its basin for seconds.
double conforming_stiffness(double k, double E, const Loads& loads);

}  // namespace brim
