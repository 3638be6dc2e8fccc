#pragma once

#include <span>
#include <vector>

#include "brim/math/types.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Deformation and stress of a solid's material, element by element.
struct StressField {
  std::vector<Vec3> place;        ///< [m] nodes of the tetrahedra, or the samples themselves; at present, world frame
  std::vector<Tetrahedron> tets;  ///< indices into `place`; empty: every place is a sample
  std::vector<double> volume;     ///< [m³] at rest, shape (tets or samples), as all that follows
  std::vector<double> filled;     ///< [-] share of the volume that is matter; empty: 1
  std::vector<Mat3> deformation;  ///< [-] F = ∂x/∂X
  std::vector<Mat3> stress;  ///< [Pa] Cauchy's σ, mean over the whole volume; elastic, symmetric, tension positive

  std::size_t size() const { return deformation.size(); }
};

/// Optional interface of bodies that are elastic solids: their stress, for export, viewer and users. Not needed by a
/// step. Tests: tests/body/stressed_solid_test.cpp
class StressedSolid {
 public:
  virtual ~StressedSolid() = default;
  /// Of the state of the last update. About 1 µs per element, on all threads.
  virtual StressField stress_field() const = 0;
  /// Values at the vertices of the display: means over the matter around each node, carried as positions are.
  /// @param value  mean over the volume of each element, shape (stress_field().size())
  /// @param out    shape (display().vertices)
  virtual void show(std::span<const double> value, std::span<float> out) const = 0;
};

/// Cauchy stress of a first Piola-Kirchhoff stress P, σ = P Fᵀ / |det F|, its symmetric part, [Pa]. Zero where F is
/// singular.
Mat3 cauchy_stress(const Mat3& P, const Mat3& F);

/// Von Mises equivalent stress √(3/2 |dev σ|²), [Pa].
double von_mises(const Mat3& stress);

/// Green-Lagrange strain ½ (FᵀF − 1), in the frame of the rest shape, [-].
Mat3 green_strain(const Mat3& F);

/// Means over the matter of the tetrahedra around each node: Σ V value / Σ V filled, shape (nodes).
std::vector<double> node_means(std::size_t nodes, std::span<const Tetrahedron> tets, std::span<const double> volume,
                               std::span<const double> filled, std::span<const double> value);

}  // namespace brim
