#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// Key of a number over time, linear between keys and constant outside them.
struct NumberKey {
  double time = 0.0, value = 1.0;
};

/// A wind field over space and time: adds the air's velocity at the points x, [m], to `velocity`, [m/s], of the same
/// shape (n). Called on the stepping thread, once per part and sub-step, with the centres of all its triangles or
/// lines, or all its points.
using WindField = std::function<void(double time, std::span<const Vec3> x, std::span<Vec3> velocity)>;

/// External actions on bodies besides gravity (docs/links.md). Like gravity, forces are constant over a sub-step.
struct AppliedForce {
  std::string name;                   ///< in messages; must be unique
  std::vector<std::string> bodies{};  ///< names, stems or patterns (TouchRule); empty: all movable bodies

  // On each body as a whole, which must be able to move rigidly:
  Vec3 force = Vec3::Zero();         ///< [N] spread over its mass, or at the point or region below
  Vec3 torque = Vec3::Zero();        ///< [N m] spread over its mass
  Vec3 acceleration = Vec3::Zero();  ///< [m/s²] in addition to gravity
  /// Factor on gravity, 1: unchanged. Buoyancy and other forces of the body are not scaled.
  std::optional<double> gravity_scale{};
  double damping = 0.0;  ///< [1/s] of all motion: velocities lose the share 1 − exp(−damping dt)

  // Where `force` acts, for bodies with points that can be held (Attachment) and for particles of fluids; at most one:
  std::optional<Vec3> point{};  ///< [m] now
  /// Of the body's vertices now; each takes an equal share. For a flow (FlowPlaces), the fluid inside the region at the
  /// time.
  std::function<bool(const Vec3&)> region{};

  /// Wind on the display geometry: triangles, lines as cylinders, points as balls (WindOnBody).
  struct Wind {
    Vec3 velocity = Vec3::Zero();   ///< [m/s] of the air
    double density = 1.2;           ///< [kg/m³]
    double drag = 1.0, lift = 0.0;  ///< [-] coefficients
    WindField field{};              ///< added to the velocity
  };
  std::optional<Wind> wind{};

  /// Attraction to a centre: acceleration strength (r/|r|) (|r|/range)^power within a range, applied to the centre of
  /// mass, or to each node of bodies with nodes.
  struct Attractor {
    Vec3 center = Vec3::Zero();  ///< [m]
    double strength = 0.0;       ///< [m/s²] at the range; negative: pushes away
    double range = 1.0;          ///< [m] zero beyond
    double power = 1.0;          ///< [-] at least 0
  };
  std::optional<Attractor> attractor{};

  std::vector<NumberKey> scale{};  ///< factor over time on everything except gravity_scale and damping; empty: 1
};

}  // namespace brim
