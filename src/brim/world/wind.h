#pragma once

#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/applied_force.h"
#include "brim/world/matter_points.h"
#include "brim/world/world_part.h"

namespace brim {

/// True when q are positions of nodes and v their velocities, with spins where nodes are balls that turn.
bool has_nodes(const Body& body);
/// True when the nodes are what the display shows: vertex i lies at q[3i ...].
bool shows_nodes(const Body& body);
/// [kg] of each node, its share of the mass matrix: row sums; shape (q / 3).
std::vector<double> node_masses(const Body& body);

/// Air that flows past what a body shows (AppliedForce::Wind), with c the air's velocity against the matter:
///   triangles  f = ½ ρ A |c|² (ĉ·n) (D (ĉ·n) ĉ + L (n − (ĉ·n) ĉ)), on both sides of a sheet, on the windward side of
///              solids and of a surface that changes, where it meets air (ChangingSurface)
///   lines      f = ½ ρ D 2r l |c⊥| c⊥, c⊥ across the line: a cylinder in cross flow, half at either end
///   points     f = ½ ρ D π r² |c| c: a ball
/// No force brings light matter beyond the speed of the air in one step.
/// Tests: tests/world/wind_test.cpp
class WindOnBody {
 public:
  /// @param parts  those of the body, which is at its last update  @param q  of the body
  /// @throws InputError  for matter that no force can act on
  WindOnBody(std::span<const WorldPart> parts, std::span<const double> q, double ramp_voxels);
  /// True where nothing is shown that air could push.
  bool empty() const { return faces_.empty() && nodes_.empty() && !changing_; }
  /// Adds the generalised force, [N]. @param scale  of the air's velocity  @param q, v, Q  of the body
  void add_force(const AppliedForce::Wind& wind, double scale, std::span<const WorldPart> parts,
                 std::span<const double> q, std::span<const double> v, double time, double dt, std::span<double> Q);

 private:
  /// Triangles of one part.
  struct Faces {
    std::size_t part = 0;  ///< within the body
    MatterPoints middles;
    std::vector<std::size_t> triangle;  ///< of the display
  };
  void add_on_faces(const AppliedForce::Wind& wind, double scale, Faces& faces, const WorldPart& part,
                    std::span<const double> q, std::span<const double> v, double time, double dt, std::span<double> Q);
  void add_on_changing(const AppliedForce::Wind& wind, double scale, const WorldPart& part, std::span<const double> v,
                       double time, double dt, std::span<double> Q) const;
  void add_on_nodes(const AppliedForce::Wind& wind, double scale, const Display& display, std::span<const double> q,
                    std::span<const double> v, double time, double dt, std::span<double> Q) const;

  std::vector<Faces> faces_;
  std::vector<double> nodes_;  ///< [kg] of lines and points
  std::size_t per_node_ = 3;   ///< velocities
  bool changing_ = false;      ///< its triangles come and go
};

}  // namespace brim
