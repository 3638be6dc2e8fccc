#pragma once

#include <array>
#include <mutex>
#include <span>
#include <vector>

#include "brim/core/workspace_pool.h"
#include "brim/grid/tile.h"
#include "brim/map/weight_rows.h"
#include "brim/raster/raster_triangles.h"

namespace brim {

/// Weights by which grid points follow the particles of a volume layer.
enum class LayerWeights : std::uint8_t {
  Mass,        ///< w_i = m_i κ_i / Σ m κ (paper, equations 4 to 6): exact for translations, wrong for rotations
  Affine,      ///< the same, corrected so that Σ w x = r: exact for every affine motion
  DensityRate  ///< along ∇ρ the rate of the density itself, tangentially Affine: forces are the gradient of an energy
};

/// The volume layer (paper, section 5.4): particles moved by any kinematics, each a volume of matter spread over a
/// ball,
///   s(r) = Σ V_i κ(|r − x_i| / R_i),   κ(q) = 105/(32 π R³) (1 − q²)²,   ρ = ramp(R u, w)
/// with R_i the largest of the particle's own radius, 0.73 w (for the ramp's slope at a flat surface) and twice
/// V_i^(1/3) (for a smooth sum), and R u the distance at which a half space of such particles has the sum s (1 + ε
/// s¹²); ε = 0.04 lifts the ripple of the sum inside above 1.
///
/// In an own body: hold a layer, set its particles in update(), and delegate presence, rasterize and weights to it.
/// With J_i the body's map of particle i, node weights go through compose() or ComposedMap. Same bits for any number of
/// threads.  Tests: tests/raster/volume_layer_test.cpp
class VolumeLayer {
 public:
  /// Least radius of influence, in edges of the particle's cube: for a smooth sum.
  static constexpr double kLeastSpacings = 2.0;

  /// @param x       [m] centres
  /// @param volume  [m³] present volume of matter, not of the ball; a stretching body passes the volume it fills
  /// @param mass    [kg] for the weights
  /// @param radius  [m] smallest radius of influence, one per particle or one for all; particles that fill only part of
  ///                their cell need kLeastSpacings of the whole cell
  /// The spans must stay valid until the next call.
  void set(std::span<const Vec3> x, std::span<const double> volume, std::span<const double> mass,
           std::span<const double> radius);

  std::size_t size() const { return x_.size(); }
  /// R_i for a ramp width, [m].
  double influence(std::size_t i, double w) const;
  /// Box of all centres, [m].
  const Aabb& centers() const { return box_; }

  void presence(double h, double w, const Aabb& region, std::vector<TileKey>& out) const;
  /// The source of a node encodes its nearest particle and w, particle 2 kWidths + slot of w.
  void rasterize(double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const;
  /// Weights over particles at points near nodes with these sources. If few particles are in reach and the affine
  /// correction would exceed Σ|w| = 8, the weights are those of Mass; if none is in reach, the source's particle has
  /// weight 1.
  WeightRows weights(std::span<const Vec3> points, std::span<const std::int32_t> sources, LayerWeights kind) const;
  /// Source of the matter at a point near a node: its weights are Affine whatever kind is asked for, so that they
  /// reproduce the place, which those of Mass and DensityRate do not. @param source  of the node
  static std::int32_t source_of_matter(std::int32_t source) { return source | kWidths; }

 private:
  static constexpr int kWidths = 8;  // a power of two
  static int particle_of(std::int32_t source) { return source / (2 * kWidths); }
  static int width_of(std::int32_t source) { return source % kWidths; }
  static bool is_matter(std::int32_t source) { return (source & kWidths) != 0; }
  /// A particle in reach of a point.
  struct Neighbour {
    std::int32_t particle;
    double weight;  ///< m κ over its sum
    Vec3 gradient;  ///< V ∇κ, [1/m]
  };
  int slot_of(double w) const;
  Vec3 collect(std::span<const std::int32_t> around, const Vec3& r, double w, double wider,
               std::vector<Neighbour>& near) const;

  std::span<const Vec3> x_;
  std::span<const double> volume_, mass_, radius_;
  std::vector<double> edge_;  // [m] V_i^(1/3)
  Aabb box_;
  mutable std::mutex mutex_;
  mutable std::array<double, kWidths> width_{};  // [m] ramp widths that were rasterized
  mutable int widths_ = 0;
  mutable WorkspacePool<RasterWorkspace> workspace_;
};

}  // namespace brim
