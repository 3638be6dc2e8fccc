#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "brim/math/types.h"

namespace brim {

/// A number over time, linear between its keys and held outside of them.
struct NumberKey {
  double time = 0.0, value = 1.0;
};

/// A velocity of air that varies over space and time: adds what it is at places x, [m], to `velocity`, [m/s], of the
/// same shape (n). Called on the stepping thread, once per part and sub-step, with the middles of all its triangles or
/// lines, or all its points.
using WindField = std::function<void(double time, std::span<const Vec3> x, std::span<Vec3> velocity)>;

/// What acts on bodies from outside besides gravity (docs/links.md). Forces are constant over a sub-step, as gravity
/// is.
struct AppliedForce {
  std::string name;                   ///< in messages; must be unique
  std::vector<std::string> bodies{};  ///< names, stems or patterns (TouchRule); empty: all that can move

  // Of each body as a whole, which must be able to move rigidly:
  Vec3 force = Vec3::Zero();         ///< [N] spread over its mass, or at the point or region below
  Vec3 torque = Vec3::Zero();        ///< [N m] likewise spread
  Vec3 acceleration = Vec3::Zero();  ///< [m/s²] beside gravity
  /// 0: none; 1: as it is. Not of what a body has besides, such as buoyancy.
  std::optional<double> gravity_scale{};
  double damping = 0.0;  ///< [1/s] of all motion: velocities lose the share 1 − exp(−damping dt)

  // Where `force` acts, of bodies with points that can be held (Attachment) and of particles of fluids; at most one:
  std::optional<Vec3> point{};  ///< [m] now
  /// Of the body's vertices now; each takes an equal share. Of a flow (FlowPlaces) what is in that place at the time.
  std::function<bool(const Vec3&)> region{};

  /// Air that flows past what the display shows: triangles, lines as cylinders, points as balls (WindOnBody).
  struct Wind {
    Vec3 velocity = Vec3::Zero();   ///< [m/s] of the air
    double density = 1.2;           ///< [kg/m³]
    double drag = 1.0, lift = 0.0;  ///< [-] coefficients
    WindField field{};              ///< added to the velocity
  };
  std::optional<Wind> wind{};

  /// Pull towards a place: acceleration strength (r/|r|) (|r|/range)^power within a range, by the centre of mass, or
  /// node by node where bodies have nodes.
  struct Attractor {
    Vec3 center = Vec3::Zero();  ///< [m]
    double strength = 0.0;       ///< [m/s²] at the range; negative: pushes away
    double range = 1.0;          ///< [m] beyond which there is none
    double power = 1.0;          ///< [-] from 0
  };
  std::optional<Attractor> attractor{};

  std::vector<NumberKey> scale{};  ///< factor over time of all but gravity_scale and damping; empty: 1
};

}  // namespace brim
