#pragma once

#include <optional>
#include <span>

#include "brim/body/fem/averaged_elements.h"
#include "brim/body/volume/carried_body.h"
#include "brim/mesh/occupancy.h"

namespace brim {

/// Material of an image's cells that varies from cell to cell; each list is empty or covers all cells, with means over
/// the whole cell (cell_means).
struct CellMaterial {
  std::span<const float> density;  ///< [kg/m³] instead of ElasticOptions::density
  std::span<const float> young;    ///< [Pa] instead of ElasticOptions::young; an element gets the mean of its matter
};

/// Deformable raw volume (paper, section 5.4): voxels of matter are embedded in a lattice of tetrahedra, which deform
/// as finite elements; the voxels make the density, and forces go from grid to voxels to lattice. The stiffness of a
/// tetrahedron is that of a full one times its fraction of matter, at least 5 %. For edge domains (AveragedElements)
/// the matter nearest to each edge counts.
/// Tests: tests/body/carried_body_test.cpp
class SoftImageBody final : public CarriedBody {
 public:
  /// @param matter   cells about as wide as a voxel of contact, in the body's own frame
  /// @param spacing  [m] of the lattice
  /// @param rotation, position  initial pose of the body
  /// @throws InputError  when a number is out of range or there is no matter
  SoftImageBody(const OccupancyGrid& matter, const TriMesh& surface, double spacing, const Quat& rotation,
                const Vec3& position, ElasticOptions options, const CellMaterial& material = {});

  std::string_view kind() const override { return "image_volume"; }
  PartInfo part(int p) const override {
    PartInfo info = CarriedBody::part(p);
    info.areal_mass = areal_mass_;
    return info;
  }
  double elastic_energy() const override { return energy_ ? *energy_ : elements_.energy(x_); }
  const TetMesh& mesh() const { return parts_.mesh; }
  StressField stress_field() const override { return elements_.stress_field(parts_.mesh, x_, parts_.filled); }
  void show(std::span<const double> value, std::span<float> out) const override;

 protected:
  void add_inner() override { energy_ = elements_.add(x_, force_, stiffness_); }

 private:
  struct Parts {
    TetMesh mesh;
    Carriage carriage;
    CarriedSurface surface;
    std::vector<double> filled;     ///< [-] of each tetrahedron, share of matter
    std::vector<double> stiffness;  ///< [-] of each tetrahedron, relative to a full one of ElasticOptions::young
    std::vector<EdgeShares> edges;  ///< [-] of the sixths, likewise
    double area = 0.0;              ///< [m²] of the surface
    Aabb box;                       ///< box of the matter, in its own frame
  };
  static Parts build(const OccupancyGrid& matter, const TriMesh& surface, double spacing, const Quat& rotation,
                     const Vec3& position, ElasticOptions& options, const CellMaterial& material);
  SoftImageBody(Parts parts, const ElasticOptions& options);

  Parts parts_;
  AveragedElements elements_;
  std::optional<double> energy_;  ///< of x_, if computed with the forces
  double areal_mass_ = 0.0;       ///< [kg/m²] behind the surface; for matter thinner than the ramp, of its outline
};

}  // namespace brim
