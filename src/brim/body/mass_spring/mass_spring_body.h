#pragma once

#include <optional>

#include "brim/body/mass_spring/spring_mesh.h"
#include "brim/body/moving_display.h"
#include "brim/body/particles/strain_damped_body.h"
#include "brim/body/particles/tet_display.h"

namespace brim {

/// Options of a body of springs; the units of density and stiffness are those of a solid, a sheet or a net.
struct MassSpringOptions : ParticleOptions {
  double density = 1000.0;  ///< [kg/m³], [kg/m²] of a sheet, [kg/m] of a net
  double stiffness = 1e5;   ///< Y [Pa], [N/m] of a sheet, [N] of a net (SpringMesh)
  double thickness = 0.01;  ///< [m] of a sheet, diameter of the lines of a net; for contact
  bool slack = false;       ///< springs resist stretch only, like strings
  TriMesh display;          ///< of a solid: fine surface carried by it, for viewers only; empty: the boundary
};

/// Particles connected by springs (docs/bodies/mass_spring.md): a solid of tetrahedra, a sheet of triangles or a net of
/// lines, whose edges are the springs. There is no separate resistance to bending or change of volume.
/// Contact (paper, sections 5.2 and 5.4): solids by the band method, sheets by their thickness, nets by the radius of
/// their lines; exact in linear and angular momentum, except for the spin of a net's lines about themselves.
/// Tests: tests/body/mass_spring_body_test.cpp
class MassSpringBody final : public StrainDampedBody, public MovingDisplay {
 public:
  /// @param mesh  rest shape, world frame; every vertex in a cell
  /// @throws InputError  when a number is out of range or the mesh cannot be used
  MassSpringBody(const TetMesh& mesh, MassSpringOptions options);
  MassSpringBody(const TriMesh& mesh, MassSpringOptions options);
  MassSpringBody(const LineMesh& mesh, MassSpringOptions options);

  std::string_view kind() const override { return "mass_spring"; }
  double elastic_energy() const override { return springs_.energy(x_); }
  const SpringElements* stiff_springs() const override { return &springs_; }
  const Display& display() const override { return solid_ ? solid_->display() : display_; }
  void display_positions(std::span<Vec3f> x) const override;
  void display_velocities(std::span<const double> v, std::span<const Vec3f>, std::span<Vec3f> u) const override;

  const SpringElements& springs() const { return springs_; }

 protected:
  void add_inner() override { springs_.add(x_, force_, stiffness_, damper_); }

 private:
  MassSpringBody(std::vector<Vec3> rest, SpringMesh mesh, const MassSpringOptions& options);

  SpringElements springs_;
  double measure_;                   // of all cells, [m³, m² or m]
  std::optional<TetDisplay> solid_;  // solids only
};

}  // namespace brim
