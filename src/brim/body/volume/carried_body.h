#pragma once

#include "brim/body/matter_sources.h"
#include "brim/body/moving_display.h"
#include "brim/body/particles/particle_body.h"
#include "brim/body/stressed_solid.h"
#include "brim/body/volume/carried_volume.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// A display surface that follows the nodes by weights.
struct CarriedSurface {
  std::vector<Triangle> triangles;
  WeightRows weights;  ///< one row per vertex
};

/// Elastic body whose nodes move particles of matter (the volume layer), from which density and map are made. Derived
/// kinds define the nodes and their forces.
class CarriedBody : public ParticleBody, public MatterSources, public StressedSolid, public MovingDisplay {
 public:
  void update(double time, std::span<const double> q, std::span<const double> v) override;
  PartInfo part(int) const override { return part_; }
  Aabb bounds(int) const override { return volume_.bounds(); }
  double relative_speed_bound(int p, std::span<const double> v) const override;
  void presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const override;
  void rasterize(int, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const override;
  void make_map(int, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;
  std::int32_t source_of_matter(std::int32_t source) const override { return VolumeLayer::source_of_matter(source); }
  const Display& display() const override { return display_; }
  void display_positions(std::span<Vec3f> x) const override;
  void display_velocities(std::span<const double> v, std::span<const Vec3f>, std::span<Vec3f> u) const override;

  const CarriedVolume& volume() const { return volume_; }

 protected:
  /// @param nodes     [m] at rest, world frame
  /// @param carriage  particles at rest
  /// @param modulus   [Pa] Young's modulus
  CarriedBody(std::vector<Vec3> nodes, Carriage carriage, LayerWeights weights, CarriedSurface surface, double modulus,
              ParticleOptions options);
  /// Values of nodes at the vertices of the display.
  void show_nodes(std::span<const double> value, std::span<float> out) const;

 private:
  /// Positions or velocities of nodes at the vertices of the display.
  void carry(std::span<const Vec3> nodes, std::span<Vec3f> out) const;

  CarriedVolume volume_;
  WeightRows surface_;
  double largest_row_ = 1.0;  // Σ|φ|: largest ratio of particle to node speed
  PartInfo part_;
  Display display_;
};

/// Material of a carried body.
struct ElasticOptions : ParticleOptions {
  double density = 1000.0;   ///< [kg/m³]
  double young = 1e5;        ///< [Pa]
  double poisson = 0.3;      ///< [-], in (−1, 0.5)
  bool neo_hookean = false;  ///< false: corotational
  double averaging = 0.0;    ///< [-] as for finite elements (AveragedElements); image volumes only
  LayerWeights weights = LayerWeights::DensityRate;
};

}  // namespace brim
