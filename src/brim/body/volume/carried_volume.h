#pragma once

#include <memory>
#include <span>

#include "brim/map/map.h"
#include "brim/map/weight_rows.h"
#include "brim/raster/volume_layer.h"

namespace brim {

/// Particles of matter that follow nodes by fixed weights: the volume layer of bodies whose shape differs from their
/// mesh.
///   x_i = Σ_k φ_ik q_k,   F_i = Σ_k q_k ∇φ_ikᵀ,   V_i = V_i⁰ det F_i
struct Carriage {
  WeightRows weights;          ///< φ, rows are particles, sources are nodes
  std::vector<Vec3> gradient;  ///< [1/m] ∇φ in the rest shape, per entry
  std::vector<double> volume;  ///< [m³] at rest
  std::vector<double> mass;    ///< [kg]
  double radius = 0.0;         ///< [m] smallest radius of influence; used if above the largest particle's
};

/// Tests: tests/body/carried_body_test.cpp
class CarriedVolume {
 public:
  explicit CarriedVolume(Carriage carriage, LayerWeights kind = LayerWeights::DensityRate);
  CarriedVolume(const CarriedVolume&) = delete;
  CarriedVolume& operator=(const CarriedVolume&) = delete;

  /// Moves the particles with the nodes. @param nodes  [m]
  void update(std::span<const Vec3> nodes);
  const VolumeLayer& layer() const { return layer_; }
  std::span<const Vec3> positions() const { return x_; }
  std::span<const double> volumes() const { return volume_; }
  const Carriage& carriage() const { return carriage_; }
  /// Bounding box of the matter, [m].
  Aabb bounds() const { return layer_.centers().inflated(spacing_); }
  /// Map of points over nodes. @param nodes  number of nodes
  void make_map(std::size_t nodes, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const;
  /// Mass of each node: Σ_i m_i φ_ik, at least a thousandth of the mean, [kg].
  static std::vector<double> node_masses(const Carriage& carriage, std::size_t nodes);

 private:
  Carriage carriage_;
  LayerWeights kind_;
  double spacing_ = 0.0;  // [m] edge of the largest particle's cube
  std::vector<Vec3> x_;
  std::vector<double> volume_, radius_;
  VolumeLayer layer_;
};

}  // namespace brim
