#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/particles/element_schedule.h"
#include "brim/math/block_matrix.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Membrane stiffness of a sheet, orthotropic (warp and weft), per metre of width.
struct MembraneMaterial {
  double young = 1000.0;      ///< [N/m] along the warp, E1 > 0 (Young's modulus times thickness)
  double young_weft = 0.0;    ///< [N/m] across, E2; 0: as the warp
  double poisson = 0.3;       ///< [-] ν12: narrowing across when stretched along; ν12² E2 < E1
  double shear = 0.0;         ///< [N/m] G; 0: that of an isotropic sheet, sqrt(E1 E2) / (2 (1 + ν12))
  Vec3 warp = Vec3::UnitX();  ///< direction of the warp in the rest shape; projected onto each triangle

  /// Plane stress: S11 = c11 E11 + c12 E22, S22 = c12 E11 + c22 E22, S12 = 2 g E12, [N/m].
  struct Moduli {
    double c11, c22, c12, g;
  };
  /// @throws InputError  when a modulus is not positive or the material is not stable (could release energy)
  Moduli moduli() const;
};

/// Constant-strain triangles in space, St. Venant and Kirchhoff's law:
///   F = Σ_i x_i g_iᵀ (3x2),  E = (FᵀF − I)/2,  S = C : E,  energy = A S:E/2
///   f_i = −A F S g_i,   K_ij = A [ (g_iᵀ S⁺ g_j) I + F D_ij Fᵀ ],   D_ij(a,b) = C_acbd g_i(c) g_j(d)
/// S⁺ is S without its compressive part: the stiffness is then positive semi-definite, exact in tension, and a
/// compressed sheet buckles freely. The law softens when compressed below 1/√3 of its length.
class MembraneElements {
 public:
  /// @throws InputError  when a triangle has no area or names a missing vertex
  MembraneElements(const TriMesh& rest, const MembraneMaterial& material);

  void find_pairs(const BlockMatrix& matrix);
  /// force += −∂E/∂x, stiffness += ∂²E/∂x² with S⁺. Same bits for any number of threads.
  void add(std::span<const Vec3> x, std::span<Vec3> force, BlockMatrix& stiffness) const;
  /// y += G v, the geometric stiffness (rotation of the tension) of triangles whose vertices are all chosen: G_ij = A
  /// (g_iᵀ S⁺ g_j) I.
  /// @param x  [m] positions  @param v, y  shape (3 vertices)
  void add_turning(std::span<const Vec3> x, std::span<const double> v, std::span<const std::uint8_t> chosen,
                   std::span<double> y) const;
  double energy(std::span<const Vec3> x) const;

  std::size_t size() const { return element_.size(); }
  double area() const;
  /// A third of each triangle's mass at each of its corners, [kg], shape (vertices).
  std::vector<double> lumped_mass(std::size_t vertices, double areal_density) const;
  const std::vector<std::int32_t>& nodes() const { return node_; }

 private:
  using Vec2 = Eigen::Vector2d;
  using Mat2 = Eigen::Matrix2d;
  using Mat32 = Eigen::Matrix<double, 3, 2>;
  struct Element {
    Vec2 gradient[3];  // g_i in the frame (warp, weft)
    double area;
  };
  Mat32 deformation(std::span<const Vec3> x, std::size_t k) const;
  Mat2 stress(const Mat32& F, Mat2& strain) const;

  MembraneMaterial::Moduli c_;
  ElementSchedule schedule_;
  std::vector<Element> element_;
  std::vector<std::int32_t> node_;
  std::vector<std::array<std::int32_t, 3>> pair_;  // 01, 02, 12
};

}  // namespace brim
