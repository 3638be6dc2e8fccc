#pragma once

#include <optional>

#include "brim/body/fem/averaged_elements.h"
#include "brim/body/moving_display.h"
#include "brim/body/particles/particle_body.h"
#include "brim/body/particles/tet_display.h"

namespace brim {

/// Material and options of an elastic solid.
struct FemOptions : ParticleOptions {
  double density = 1000.0;  ///< [kg/m³]
  double young = 1e5;       ///< Young's modulus E [Pa]
  double poisson = 0.3;     ///< Poisson's ratio ν [-], in (−1, 0.5); above 0.45 linear tetrahedra lock
  ElasticLaw law = ElasticLaw::CorotationalLinear;
  /// [-] in [0, 1): share of the energy stored by the mean F about each edge (AveragedElements). Reduces locking in
  /// bending at a higher cost per step. 0: plain linear tetrahedra
  double averaging = 0.0;
  TriMesh display;  ///< fine surface carried by the elements, for viewers only; empty: the boundary itself
};

/// Elastic solid of linear tetrahedra with large rotations and strains (docs/bodies/finite_elements.md).
/// Contact: the band method (raster_tets) with barycentric weights, exact in linear and angular momentum.
/// Tests: tests/body/fem_body_test.cpp
class FemBody final : public ParticleBody, public StressedSolid, public MovingDisplay {
 public:
  /// @param mesh  rest shape, world frame; every vertex in a tetrahedron
  /// @throws InputError  when a number is out of range or the mesh cannot be used
  FemBody(const TetMesh& mesh, const FemOptions& options);

  std::string_view kind() const override { return "finite_elements"; }
  double elastic_energy() const override { return energy_ ? *energy_ : elements_.energy(x_); }

  const Display& display() const override { return shown_->display(); }
  void display_positions(std::span<Vec3f> x) const override;
  void display_velocities(std::span<const double> v, std::span<const Vec3f>, std::span<Vec3f> u) const override;
  StressField stress_field() const override { return elements_.stress_field(mesh_, x_); }
  void show(std::span<const double> value, std::span<float> out) const override;

  const TetMesh& mesh() const { return mesh_; }
  std::span<const Triangle> surface() const { return surface_; }
  const TetElements& elements() const { return elements_.tets(); }

 protected:
  void add_inner() override { energy_ = elements_.add(x_, force_, stiffness_); }

 private:
  FemBody(const TetMesh& mesh, const FemOptions& options, AveragedElements elements);

  TetMesh mesh_;
  AveragedElements elements_;
  std::optional<double> energy_;       ///< of x_, if computed with the forces
  std::span<const Triangle> surface_;  // owned by the contact
  std::optional<TetDisplay> shown_;
};

}  // namespace brim
