#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "brim/math/types.h"
#include "brim/mesh/exact_cells.h"
#include "brim/mesh/kinked_cells.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Conversion of a triangle surface to a solid. Chosen by the user, never guessed.
enum class SurfaceTreatment : std::uint8_t {
  Closed,         ///< the surface must be closed and oriented; exact distance
  WindingNumber,  ///< inside: generalized winding number above 1/2; closes holes, drops inner surfaces
  Thickness       ///< the surface is a sheet: unsigned distance minus half the thickness
};

/// Interpolation between nodes. Root mean square error at random points up to 1.5 spacings from the surface, in
/// spacings, trilinear -> tricubic: sphere of 20 spacings 0.009 -> 3e-5; torus tube of 6 spacings 0.015 -> 5e-4; box
/// 0.049 -> 0.013; sharp gear 0.056 -> 0.017 (tests/mesh/distance_grid_test.cpp checks two of them).
enum class Interpolation : std::uint8_t {
  Trilinear,  ///< 8 nodes, continuous
  Tricubic    ///< 64 nodes, exact for quadratic fields and next to kinks (kinked_cubic.h)
};

/// Signed distance [m] (negative inside) sampled on a regular grid in the body's own frame.
class DistanceGrid {
 public:
  /// @param values  [m] shape (nz, ny, nx), x fastest
  DistanceGrid(const Vec3& origin, double spacing, const Vec3i& nodes, std::vector<float> values,
               Interpolation interpolation = Interpolation::Tricubic);

  /// Signed distance at p. Outside the grid: sqrt(|p−q|² + max(0, value(q))²), q the nearest point of the grid's box;
  /// at most the true distance, because the box is convex and contains the surface; continuous at the border.
  double value(const Vec3& p) const { return value(p, interpolation_); }
  double value(const Vec3& p, Interpolation interpolation) const;
  /// A lower bound of value() and of the true distance at p from the nearest node alone (distance_bounds.h); at most
  /// about two spacings below them, less than one on average, plus 2.5 % of the part beyond 4 spacings.
  double least_value(const Vec3& p) const;

  const Vec3& origin() const { return origin_; }
  double spacing() const { return spacing_; }
  double inverse_spacing() const { return inverse_spacing_; }
  const Vec3i& nodes() const { return nodes_; }
  const std::vector<float>& values() const { return values_; }
  Interpolation interpolation() const { return interpolation_; }
  const KinkedCells& kinks() const { return kinks_; }
  /// Cells in which the distance to the surface itself is taken; or null.
  const ExactCells* exact_cells() const { return exact_.get(); }
  void set_exact_cells(std::shared_ptr<const ExactCells> cells) { exact_ = std::move(cells); }
  /// Box of all nodes, [m].
  Aabb box() const { return box_; }
  /// Box of the nodes at or below `level` [m], grown by one spacing: contains the solid.
  Aabb solid_box(double level = 0.0) const;

 private:
  /// value() in the grid's box.
  double tricubic(const Vec3& p) const;
  double trilinear(const Vec3& p) const;

  Vec3 origin_;
  double spacing_, inverse_spacing_;
  Vec3i nodes_;
  std::vector<float> values_;
  Interpolation interpolation_;
  KinkedCells kinks_;
  std::shared_ptr<const ExactCells> exact_;
  Aabb box_;
};

struct DistanceGridOptions {
  double spacing = 0.0;  ///< [m], > 0
  SurfaceTreatment treatment = SurfaceTreatment::Closed;
  double thickness = 0.0;   ///< [m], for SurfaceTreatment::Thickness, > 0
  double margin = 0.0;      ///< [m] grid margin around the solid; at least 3 spacings are always added
  double exact_band = 0.0;  ///< [m] distances up to this are exact; at least 4 spacings
  std::size_t max_nodes = std::size_t{1} << 26;  ///< 256 MiB of floats
  Interpolation interpolation = Interpolation::Tricubic;
};

/// Samples the signed distance of a surface: exact (to float) at nodes up to 4 spacings (or exact_band) from it,
/// farther away at most 2 % too large; the sign is always right. Closed: distance to the triangles, sign from
/// pseudonormals; beside sharp edges not only at nodes (ExactCells). WindingNumber: distance to the closed surface of
/// winding number 1/2, extracted on the same grid, so details below the spacing are rounded off. Thickness: |d| −
/// thickness/2.
/// @throws InputError  when a size is not positive, the grid would exceed max_nodes, the surface does not suit the
///                     treatment (the message counts the open edges and names suitable treatments), or no node is
///                     inside
/// Same bits for any number of threads.  Tests: tests/mesh/distance_grid_test.cpp
DistanceGrid make_distance_grid(const TriMesh& mesh, const DistanceGridOptions& options);

/// Samples any function, called from several threads, on a grid that covers the box.
DistanceGrid sample_distance(const Aabb& box, double spacing, const std::function<double(const Vec3&)>& distance,
                             std::size_t max_nodes = std::size_t{1} << 26);

/// Volume, mass, centre and inertia of the solid value(p) < 0, from its level surface on the grid. For bodies without a
/// closed surface. @throws InputError when the grid contains no solid
MassProperties mass_properties(const DistanceGrid& grid, double density);

}  // namespace brim
