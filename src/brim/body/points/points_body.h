#pragma once

#include "brim/body/particles/particle_body.h"
#include "brim/body/points/grain_pairs.h"

namespace brim {

/// What grains are made of. stiffness_damping is the damping of grain on grain, with motions and fixed as for all
/// bodies of particles.
struct PointsOptions : ParticleOptions {
  std::vector<double> radius = {0.01};  ///< [m] one per grain, or a single one for all
  double density = 2500.0;              ///< [kg/m³] of the matter of a grain
  double young = 1e6;                   ///< E [Pa] of grain on grain (GrainMaterial)
  double friction = 0.5;                ///< of grain on grain, [-], >= 0
  double gravity = 9.81;                ///< [m/s²] of the world, for the release of pairs (GrainMaterial)
  double slip_speed = 1e-3;             ///< [m/s] width of regularised friction, > 0
};

/// Grains: balls that move but do not turn (docs/bodies/points.md). They push and rub each other as the body's own
/// inner forces (GrainPairs); to everything else they are one part.
/// Contact (paper, section 5.2): raster_points, J = I; linear momentum is exact, angular momentum but for the spin that
/// friction would give a grain.
/// Tests: tests/body/points_body_test.cpp
class PointsBody final : public ParticleBody {
 public:
  /// @param centers  [m], world frame, at least one
  /// @throws InputError  when a number is out of range
  PointsBody(std::vector<Vec3> centers, PointsOptions options);

  std::string_view kind() const override { return "points"; }
  double elastic_energy() const override { return pairs_.energy(); }

  void add_forces(const Environment& env, std::span<double> Q) const override;
  void apply_stiffness(std::span<const double> x, std::span<double> y) const override;
  void apply_damping(std::span<const double> x, std::span<double> y) const override;
  void begin_solve(double dt) override;
  void apply_system(std::span<const double> x, std::span<double> y) const override;
  std::optional<BlockSystem> block_system() const override { return std::nullopt; }  // pairs come and go
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override;

  std::span<const double> radii() const { return radius_; }
  const GrainPairs& pairs() const { return pairs_; }

 protected:
  void add_inner() override;

 private:
  PointsBody(std::vector<Vec3> centers, std::vector<double> radius, const PointsOptions& options);
  /// How far apart grains may be that can meet within a step, [m].
  double gap_for(double dt) const;

  std::vector<double> radius_;  // [m], per grain
  GrainMaterial material_;
  GrainPairs pairs_;
  std::vector<Vec3> pair_force_;  // [N], with damping and friction
};

}  // namespace brim
