#pragma once

#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/applied_force.h"
#include "brim/world/matter_points.h"
#include "brim/world/world_part.h"

namespace brim {

/// True when q are node positions and v their velocities, with spins for nodes that are spinning balls.
bool has_nodes(const Body& body);
/// True when the display shows the nodes: vertex i lies at q[3i ...].
bool shows_nodes(const Body& body);
/// True when air acts on the body within the system of a step: it has nodes of three velocities and does not flow.
bool yields_implicitly(const Body& body);
/// [kg] lumped mass per node: row sums of the mass matrix; shape (q / 3).
std::vector<double> node_masses(const Body& body);

/// The air of a wind over a sub-step.
struct AirStep {
  const AppliedForce::Wind& wind;
  double scale = 1.0;  ///< of the air's velocity
  double time = 0.0;   ///< [s]
  double dt = 0.0;     ///< [s]
  /// [m/s] The air's velocity at each place, before `scale`. @param x  [m]
  std::vector<Vec3> velocity_at(std::span<const Vec3> x) const;
};

/// Wind on a body's display geometry (AppliedForce::Wind), with c the air's velocity relative to the material:
///   triangles  f = ½ ρ A |c|² (ĉ·n) (D (ĉ·n) ĉ + L (n − (ĉ·n) ĉ)), on both sides of a sheet, on the windward side of
///              solids and, where it meets air, of a changing surface (ChangingSurface)
///   lines      f = ½ ρ D 2r l |c⊥| c⊥, c⊥ perpendicular to the line: a cylinder in cross flow, half at either end
///   points     f = ½ ρ D π r² |c| c: a ball
/// No light matter is accelerated beyond the air's speed in one step. Bodies of nodes (yields_implicitly) answer to air
/// within the step: the force is that on their present velocity, and the system of the step resists its change by
///   R = ρ A |c| (L n nᵀ + |D − L| (ĉ·n)² ĉ ĉᵀ),  lines ρ D 2r l |c⊥| (1 − e eᵀ),  points ρ D π r² |c|
/// at least as much as the derivative of the force, so that a steady load is exact. For others (rigid bodies, grains,
/// drops) the force itself is made smaller, by 1 + dt R/m with m their areal mass; it is exact where that is close
/// to 1. Tests: tests/world/wind_test.cpp
class WindOnBody {
 public:
  /// @param parts  those of the body, which is at its last update  @param q  of the body
  /// @throws InputError  for matter that cannot take forces
  WindOnBody(std::span<const WorldPart> parts, std::span<const double> q, double ramp_voxels);
  /// True when the display has nothing that air could push.
  bool empty() const { return faces_.empty() && nodes_.empty() && !changing_; }
  /// Adds the generalised force, [N]. @param q, v, Q  of the body
  /// @param resistance  [kg/s] R of its nodes is added to it; empty: the force is limited instead
  void add_force(const AirStep& step, std::span<const WorldPart> parts, std::span<const double> q,
                 std::span<const double> v, std::span<double> Q, std::span<Mat3> resistance);

 private:
  /// Triangles of one part.
  struct Faces {
    std::size_t part = 0;  ///< within the body
    MatterPoints middles;
    std::vector<std::size_t> triangle;  ///< of the display
  };
  static void add_on_faces(const AirStep& step, Faces& faces, const WorldPart& part, std::span<const double> q,
                           std::span<const double> v, std::span<double> Q, std::span<Mat3> resistance);
  static void add_on_changing(const AirStep& step, const WorldPart& part, std::span<const double> v,
                              std::span<double> Q);
  void add_on_nodes(const AirStep& step, const Display& display, std::span<const double> q, std::span<const double> v,
                    std::span<double> Q, std::span<Mat3> resistance) const;

  std::vector<Faces> faces_;
  std::vector<double> nodes_;  ///< [kg] of lines and points
  std::size_t per_node_ = 3;   ///< velocities
  bool changing_ = false;      ///< its triangles appear and disappear
};

}  // namespace brim
