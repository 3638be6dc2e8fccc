#pragma once

#include <memory>
#include <vector>

#include "brim/body/body.h"
#include "brim/body/filling.h"
#include "brim/body/known_volume.h"
#include "brim/body/longest_step.h"
#include "brim/body/loose_nodes.h"
#include "brim/body/motion_clusters.h"
#include "brim/body/movable.h"
#include "brim/body/outer_forces.h"
#include "brim/body/particle_fluid/cohesion.h"
#include "brim/body/particle_fluid/fluid_contact.h"
#include "brim/body/particle_fluid/fluid_images.h"
#include "brim/body/particle_fluid/fluid_lattice.h"
#include "brim/body/particle_fluid/fluid_pairs.h"
#include "brim/body/restless.h"

namespace brim {

/// Material and options of a particle fluid.
struct ParticleFluidOptions {
  double spacing = 0.05;                 ///< [m] of the particles at rest, > 0: each stands for spacing³ of fluid
  double density = 1000.0;               ///< [kg/m³]
  double viscosity = 0.0;                ///< [Pa s] dynamic, >= 0; implicit, so it does not limit the time step
  double surface_tension = 0.0;          ///< [N/m] >= 0; explicit, see docs for the time step that it allows
  double bulk_modulus = 0.0;             ///< [Pa] κ; 0: ρ (g L + v²) / compression, L: diagonal of the initial fluid
  double compression = 0.01;             ///< [-] allowed when κ is chosen, (0, 0.1]
  Vec3 gravity = Vec3(0, 0, -9.81);      ///< [m/s²] assumed in the choice of κ
  Vec3 initial_velocity = Vec3::Zero();  ///< [m/s]
  Vec3 initial_spin = Vec3::Zero();      ///< [rad/s] about the centre of mass
  double voxel_size = 0.0;               ///< [m] grid step for contact, at most the spacing; 0: half of it
  Material material;
};

/// Liquid of particles (smoothed particle hydrodynamics) whose incompressibility is part of the common implicit solve
/// (docs/bodies/particle_fluid.md): pressure, viscosity and the contact with bodies of every kind are found together.
///
///   E = Σ ½ κ V (φ_i − 1)₊²      φ_i = Σ_j V W(x_i − x_j), the filled fraction of space
///   K = Σ s_i κ V ∇φ_i ∇φ_iᵀ     s_i from 0 at φ = 0.90 to 1 at 0.98: particles inside the fluid, full or nearly
///
/// K regardless of the sign of φ − 1 keeps the density inside from changing in either direction, like the velocity step
/// of divergence-free SPH (Bender and Koschier 2017); E removes compression. Both are linearly implicit (energy and its
/// treatment: Weiler, Koschier and Bender 2016), so κ does not limit the time step.
/// Tests: tests/body/particle_fluid_test.cpp
class ParticleFluidBody final : public Body,
                                public Filling,
                                public LooseNodes,
                                public OuterForces,
                                public Restless,
                                public Movable,
                                public MotionClusters,
                                public LongestStep,
                                public KnownVolume {
 public:
  /// @param x  particles at the start, world frame, [m]
  /// @throws InputError  when a number is out of range or there are no particles
  ParticleFluidBody(std::vector<Vec3> x, ParticleFluidOptions options);

  std::string_view kind() const override { return "particle_fluid"; }
  bool restless() const override { return true; }
  double longest_step() const override { return cohesion_.longest_step(options_.density, options_.spacing); }
  std::size_t q_size() const override { return 3 * start_.size(); }
  std::size_t v_size() const override { return 3 * start_.size(); }
  void initial_state(std::span<double> q, std::span<double> v) const override;
  void update(double time, std::span<const double> q, std::span<const double> v) override;
  void advance(double dt, std::span<double> q, std::span<const double> v) const override;
  void move(const Pose& by, std::span<double> q, std::span<double> v) const override { move_points(by, q, v); }

  void add_forces(const Environment& env, std::span<double> Q) const override;
  void apply_mass(std::span<const double> x, std::span<double> y) const override;
  void apply_stiffness(std::span<const double> x, std::span<double> y) const override;
  void apply_damping(std::span<const double> x, std::span<double> y) const override;
  void apply_system(std::span<const double> x, std::span<double> y) const override;
  std::vector<int> block_sizes() const override { return std::vector<int>(start_.size(), 3); }
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override;

  PartInfo part(int) const override { return part_; }
  Aabb bounds(int p) const override;
  Vec3 mean_velocity(int p, std::span<const double> v) const override;
  double relative_speed_bound(int p, std::span<const double> v) const override;
  void motion_clusters(int p, std::span<const double> v, std::vector<MotionCluster>& out) const override;
  void finer_clusters(int p, std::size_t cluster, std::span<const double> v,
                      std::vector<MotionCluster>& out) const override;
  bool meets_itself() const override { return true; }
  void presence(int p, double h, double w, const Aabb& region, std::vector<TileKey>& out) const override;
  void rasterize(int p, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const override;
  void make_map(int p, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;

  std::int32_t nearest_node(const Vec3& x) const override;
  std::int32_t source_of_node(std::int32_t node) const override { return Filling::source_of(node); }

  std::span<const Vec3> fill_places() const override { return x_; }
  double fill_reach() const override { return images_.reach(); }
  double fill_gap() const override { return 0.5 * options_.spacing; }
  void see(std::span<const Seen> seen) override;
  void foresee(double dt, std::span<const double> v, std::span<const double> rate) override;
  void press(std::span<double> push) const override;
  void apply_stiffness_seeing(std::span<const double> x, std::span<const double> rate, std::span<double> y,
                              std::span<double> change) const override;
  void apply_system_seeing(std::span<const double> x, std::span<const double> rate, std::span<double> y,
                           std::span<double> change) const override;
  double fill_stiffness(std::size_t k, double dt) const override;
  double fill_drag(std::size_t k) const override;

  double mass() const override { return particle_mass_ * static_cast<double>(start_.size()); }
  double volume() const override { return mass() / options_.density; }
  double potential_energy(const Environment& env) const override;
  Vec3 linear_momentum(std::span<const double> v) const override;
  Vec3 angular_momentum(std::span<const double> v) const override;
  bool rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const override;

  const Display& display() const override { return display_; }
  void display_positions(std::span<Vec3f> x) const override;

  // ---- for tests and tools ---------------------------------------------------------------------------------------
  double bulk_modulus() const { return bulk_modulus_; }
  double particle_mass() const { return particle_mass_; }
  /// φ of the last updated state in the order of the particles, surfaces included, [-].
  std::vector<double> fill() const;
  /// Pressure κ (φ − 1)₊ likewise, [Pa].
  std::vector<double> pressure() const;

 private:
  using Vec4 = FluidPairs::Vec4;
  struct Product {  ///< workspace of one product, cell order
    std::vector<Vec4> v;
    std::vector<float> rate, pressure;
    std::vector<Vec3> y;
  };
  void gather(std::span<const double> x, Product& p) const;
  void scatter(const Product& p, double scale, std::span<double> y) const;
  /// y += scale (pressure_factor κ-part + viscous_factor viscous part) x
  /// @param rate  of the distances to surfaces, and change = pressure_factor times the change of push; both of shape
  ///              (seen) or empty
  void multiply(double pressure_factor, double viscous_factor, std::span<const double> x, std::span<double> y,
                std::span<const double> rate = {}, std::span<double> change = {}) const;
  void judge_fill();
  /// ∂²E/∂φ², [J].
  double fill_energy() const { return bulk_modulus_ * particle_mass_ / options_.density; }

  std::vector<Vec3> start_;
  ParticleFluidOptions options_;
  FluidKernel kernel_;
  Cohesion cohesion_;
  double volume_, particle_mass_, bulk_modulus_;
  PartInfo part_;
  Display display_;

  std::vector<Vec3> x_;    ///< of the last update, the caller's order
  std::vector<double> v_;  ///< likewise
  ParticleCells cells_;
  FluidPairs pairs_;
  FluidContact contact_;
  FluidImages images_;
  std::vector<Seen> seen_;
  std::vector<std::int32_t> slot_;  ///< index in cell order of each particle
  std::vector<double> fill_;        ///< φ, cell order, surfaces included
  std::vector<double> excess_;      ///< φ − 1 that causes pressure, cell order; below 0 where a surface will be met
  std::vector<float> inside_;       ///< s_i, cell order
  mutable WorkspacePool<Product> products_;
};

}  // namespace brim
