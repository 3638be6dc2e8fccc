#pragma once

#include "brim/body/cloth/bending_elements.h"
#include "brim/body/cloth/membrane_elements.h"
#include "brim/body/particles/particle_body.h"

namespace brim {

/// Material and options of a sheet.
struct ClothOptions : ParticleOptions {
  double areal_density = 0.2;  ///< [kg/m²]
  double thickness = 0.01;     ///< [m] for contact only; the voxel size follows it (thickness / 2)
  MembraneMaterial membrane;
  double bending = 1e-5;  ///< B [N·m], >= 0 (E t³ / (12 (1 − ν²)) for a homogeneous plate)
};

/// Cloth, paper or shell: triangles with membrane and bending stiffness (docs/bodies/cloth.md). A flat rest shape uses
/// the quadratic bending model, a curved one keeps its rest angles.
/// Contact: density of a slab of the given thickness (raster_triangles) with shell weights, exact in linear and angular
/// momentum. The thickness should be at least two voxels.
/// Tests: tests/body/cloth_body_test.cpp
class ClothBody final : public ParticleBody {
 public:
  /// @param mesh  rest shape, world frame, any manifold surface, open or closed; every vertex in a triangle
  /// @throws InputError  when a number is out of range or the mesh cannot be used
  ClothBody(TriMesh mesh, ClothOptions options);

  std::string_view kind() const override { return "cloth"; }
  double elastic_energy() const override { return membrane_.energy(x_) + bending_.energy(x_); }

  const TriMesh& mesh() const { return mesh_; }
  const MembraneElements& membrane() const { return membrane_; }
  const BendingElements& bending() const { return bending_; }

 protected:
  void add_inner() override;
  void add_turning_stiffness(std::span<const double> x, std::span<const std::uint8_t> guided,
                             std::span<double> y) const override;

 private:
  ClothBody(TriMesh mesh, ClothOptions options, MembraneElements membrane);

  TriMesh mesh_;
  MembraneElements membrane_;
  BendingElements bending_;
};

}  // namespace brim
