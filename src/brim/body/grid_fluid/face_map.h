#pragma once

#include <functional>
#include <vector>

#include "brim/body/grid_fluid/mac_grid.h"
#include "brim/body/grid_fluid/surface_faces.h"
#include "brim/body/grid_fluid/wet_faces.h"
#include "brim/map/directed_map.h"
#include "brim/map/map.h"

namespace brim {

/// Velocity of a point per unit velocity of a face.
struct FaceWeight {
  std::int32_t face;
  Vec3 weight;
};

/// Share of the material's own velocity in the surface velocity, in addition to the flow through the surface: none
/// tangentially when the fluid slips in contact, all when it sticks; the free surface follows its material.
enum class SurfaceMotion { Slips, Sticks, Follows };

/// Velocity of the surface at the point nearest to x, as a sum over faces. A force on a fluid's surface is a pressure:
/// it must act on the faces as the air pressure beyond the surface would, or it stirs the fluid (balanced forces,
/// Francois et al. 2006). So along the normal n the velocity is the flow through the surface,
///   s_f = ±K(|x − x_f|)  for faces f between a wet and a dry cell, signed towards the dry one;   g = Σ_f s_f e_f
///   u = β n/(g·n) Σ_f s_f v_f + R Σ_f w_f v_f,     β = (g·n)²/((g·n)² + ε²)
/// with x_f where the surface cuts the line between the two cells' centres, K a Gaussian of 0.75 cells minus its value
/// at its end, two cells, n the mean ∇φ over two cells, w the trilinear weights among wet faces, each times the fluid
/// it moves (Σ w = 1), and
///   R = (1 − β) n nᵀ             for a fluid that slips,
///   R = I − β n gᵀ/(g·n)         for one that sticks; reproduces a constant field,
///   R = I − β n nᵀ               for the surface itself, with the tangential velocity of its material.
/// A fluid without shear must not receive any, or a contact normal slightly off that of the surface would drive it
/// along the wall for ever. So a slipping fluid receives a force f as Pf, P = p nᵀ with p = β g/(g·n) + (1 − β) n, and
/// forces along p unchanged: Pp = p. More than two cells below the surface (at the walls of the box) u is Σ w v. Empty
/// far from any wet face.
/// @param surface  found for the same wet faces and φ
/// @param motion   which R
/// @return p over its length; zero when u is that of a constant field, and forces of any direction are accepted
Vec3 surface_row(const MacGrid& grid, const WetFaces& wet, const SurfaceFaces& surface, std::span<const double> phi,
                 SurfaceMotion motion, const Vec3& x, std::vector<FaceWeight>& row);
/// u for given face velocities, [m/s]. @param row  workspace
Vec3 surface_velocity(const MacGrid& grid, const WetFaces& wet, const SurfaceFaces& surface,
                      std::span<const double> phi, SurfaceMotion motion, std::span<const double> v, const Vec3& x,
                      std::vector<FaceWeight>& row);

/// Map of a grid fluid: points move as the nearest surface. The linear momentum of contact is exact, for a slipping
/// fluid only for forces along its directions. Angular momentum is not exact. Constant during a step. Tests:
/// tests/body/face_map_test.cpp
class FaceMap final : public Map, public DirectedMap {
 public:
  /// @param motion  SurfaceMotion of contact in a cell
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
  std::vector<FaceWeight> entry_;  ///< by point
  std::vector<Vec3> direction_;    ///< by point
  SurfaceFaces surface_;
  std::vector<std::vector<FaceWeight>> row_;  ///< workspace
};

}  // namespace brim
