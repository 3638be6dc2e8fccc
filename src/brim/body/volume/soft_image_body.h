#pragma once

#include <optional>
#include <span>

#include "brim/body/fem/averaged_elements.h"
#include "brim/body/volume/carried_body.h"
#include "brim/mesh/occupancy.h"

namespace brim {

/// What the cells of an image are made of where it differs from cell to cell; each list is empty or of all cells, a
/// mean over the whole cell (cell_means).
struct CellMaterial {
  std::span<const float> density;  ///< [kg/m³] instead of ElasticOptions::density
  std::span<const float> young;    ///< [Pa] instead of ElasticOptions::young; an element has the mean of its matter
};

/// Deformable raw volume (paper, section 5.4): voxels of matter ride in a lattice of tetrahedra that deform as finite
/// elements do; the voxels make the density, and forces go from grid to voxels to lattice.
/// Each tetrahedron has the stiffness of the matter that it holds: that of a full one times its share of matter, 5 % of
/// it at least. About edges (AveragedElements) the matter counts that is nearest to each.
/// Tests: tests/body/carried_body_test.cpp
class SoftImageBody final : public CarriedBody {
 public:
  /// @param matter   cells about as wide as a voxel of contact, in the body's own frame
  /// @param spacing  [m] of the lattice
  /// @param rotation, position  where the body starts
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

 protected:
  void add_inner() override { energy_ = elements_.add(x_, force_, stiffness_); }

 private:
  struct Parts {
    TetMesh mesh;
    Carriage carriage;
    CarriedSurface surface;
    std::vector<double> stiffness;  ///< [-] of each tetrahedron, over that of one full of ElasticOptions::young
    std::vector<EdgeShares> edges;  ///< [-] of its sixths, likewise
    double area = 0.0;              ///< [m²] of the surface
    Aabb box;                       ///< around the matter, in its own frame
  };
  static Parts build(const OccupancyGrid& matter, const TriMesh& surface, double spacing, const Quat& rotation,
                     const Vec3& position, ElasticOptions& options, const CellMaterial& material);
  SoftImageBody(Parts parts, const ElasticOptions& options);

  Parts parts_;
  AveragedElements elements_;
  std::optional<double> energy_;  ///< of x_, where it came with the forces
  double areal_mass_ = 0.0;       ///< [kg/m²] behind the surface, of what is thinner than the ramp that of its outline
};

}  // namespace brim
