#pragma once

#include <functional>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/body/grid_fluid/wet_faces.h"
#include "brim/map/directed_map.h"
#include "brim/map/map.h"

namespace brim {

/// Velocity of a point per velocity of a face.
struct FaceWeight {
  std::int32_t face;
  Vec3 weight;
};

/// What of its matter's own velocity the surface of a fluid has besides the flow through it: in contact none where the
/// fluid slips, and all where it sticks; the surface itself follows its matter along it.
enum class SurfaceMotion { Slips, Sticks, Follows };

/// The velocity of the surface at the point nearest to x, as a sum over faces. A force on the surface of a fluid is a
/// pressure: it must reach the faces as the pressure of the air beyond the surface would, or it stirs the fluid
/// (balanced forces, Francois et al. 2006). So along the normal n the velocity is the flow through the surface,
///   s_f = ±K(|x − x_f|)  for faces f between a wet and a dry cell, signed towards the dry one;   g = Σ_f s_f e_f
///   u = β n/(g·n) Σ_f s_f v_f + R Σ_f w_f v_f,     β = (g·n)²/((g·n)² + ε²)
/// with x_f where the surface cuts the line between the two cells' centres, K a Gaussian of 0.75 cells less what it is
/// at two, where it ends, n the mean ∇φ over two cells, w the trilinear weights among wet faces, each times how much
/// fluid it moves (Σ w = 1), and
///   R = (1 − β) n nᵀ             for a fluid that slips,
///   R = I − β n gᵀ/(g·n)         for one that sticks; it reproduces a constant field,
///   R = I − β n nᵀ               for the surface itself, which has the velocity of its matter along it.
/// A fluid that knows no shear must take none, else a contact normal that is not quite that of the surface would drive
/// it along the wall for ever. So one that slips takes a force f as Pf, P = p nᵀ with p = β g/(g·n) + (1 − β) n, and
/// what lies along p it takes whole: Pp = p. More than two cells below the surface (at the walls of the box) u is Σ w
/// v. Empty far from any wet face.
/// @param motion  which R
/// @return p over its length; zero where u is that of a constant field, and every force is taken whole
Vec3 surface_row(const MacGrid& grid, const WetFaces& wet, std::span<const double> phi, SurfaceMotion motion,
                 const Vec3& x, std::vector<FaceWeight>& row);
/// u for these velocities of faces, [m/s]. @param row  workspace
Vec3 surface_velocity(const MacGrid& grid, const WetFaces& wet, std::span<const double> phi, SurfaceMotion motion,
                      std::span<const double> v, const Vec3& x, std::vector<FaceWeight>& row);

/// Map of a grid fluid: points move as the surface nearest to them. The linear momentum of contact is exact: for a
/// fluid that slips, of forces along its directions. Angular momentum is not exact. Constant during a step. Tests:
/// tests/body/face_map_test.cpp
class FaceMap final : public Map, public DirectedMap {
 public:
  /// @param motion  how contact takes the surface's motion in a cell
  void reset(const MacGrid& grid, const WetFaces& wet, std::span<const double> phi,
             const std::function<SurfaceMotion(int cell)>& motion, std::span<const Vec3> points);
  void reset(const MacGrid& grid, const WetFaces& wet, std::span<const double> phi, SurfaceMotion motion,
             std::span<const Vec3> points) {
    reset(
        grid, wet, phi, [motion](int) { return motion; }, points);
  }

  std::span<const Vec3> directions() const override { return direction_; }
  std::size_t points() const override { return row_start_.empty() ? 0 : row_start_.size() - 1; }
  void apply(std::span<const double> v, std::span<Vec3> u) const override;
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override;
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override;

 private:
  std::vector<std::size_t> row_start_;
  std::vector<FaceWeight> entry_;             ///< by point
  std::vector<Vec3> direction_;               ///< by point
  std::vector<std::vector<FaceWeight>> row_;  ///< workspace
};

}  // namespace brim
