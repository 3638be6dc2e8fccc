#pragma once

#include "brim/body/foresees_contact.h"
#include "brim/body/particles/particle_body.h"
#include "brim/body/particles/particle_cells.h"
#include "brim/body/points/grain_pairs.h"
#include "brim/body/spinning_balls.h"

namespace brim {

/// Material and options of grains. stiffness_damping is the damping between grains; motions and fixed are as for all
/// bodies of particles.
struct PointsOptions : ParticleOptions {
  std::vector<double> radius = {0.01};  ///< [m] one per grain, or a single one for all
  double density = 2500.0;              ///< [kg/m³] of the material of a grain
  double young = 1e6;                   ///< E [Pa] of grain on grain (GrainMaterial)
  double friction = 0.5;                ///< of grain on grain, [-], >= 0
  bool turn = true;                     ///< false: no spin, like interlocking grains; friction then has no torque
  double rolling_friction = 0.1;        ///< μ_r of grains that roll on each other and on fixed parts, [-], >= 0
  double gravity = 9.81;                ///< [m/s²] of the world, for the release of pairs (GrainMaterial)
  double slip_speed = 1e-3;             ///< [m/s] width of regularised friction, > 0
};

/// Grains: balls that move and rotate (docs/bodies/points.md). q has a centre per grain, v its velocity and spin ω,
/// with the inertia 2/5 m r². Contact between grains is an internal force of the body (GrainPairs); for all others they
/// are one part. Contact (paper, section 5.2): raster_points, BallsMap; momentum and angular momentum are exact.
/// Tests: tests/body/points_body_test.cpp
class PointsBody final : public ParticleBody, public SpinningBalls, public BlocksOfSix, public ForeseesContact {
 public:
  /// @param centers  [m], world frame, at least one
  /// @throws InputError  when a number is out of range
  PointsBody(std::vector<Vec3> centers, PointsOptions options);

  std::string_view kind() const override { return "points"; }
  double elastic_energy() const override { return pairs_.energy(); }
  std::int32_t balls() const override { return static_cast<std::int32_t>(radius_.size()); }
  const Vec3& ball_center(std::int32_t source) const override { return x_[static_cast<std::size_t>(source)]; }
  double ball_radius(std::int32_t source) const override { return radius_[static_cast<std::size_t>(source)]; }
  double least_radius() const override { return smallest_; }

  void set_loads(std::span<const double> load) override { load_.assign(load.begin(), load.end()); }

  std::size_t v_size() const override { return 6 * rest_.size(); }
  void initial_state(std::span<double> q, std::span<double> v) const override;
  void prescribe(double time, double dt, std::span<const double> q, std::span<double> v) const override;
  void update(double time, std::span<const double> q, std::span<const double> v) override;
  void advance(double dt, std::span<double> q, std::span<const double> v) const override;
  void move(const Pose& by, std::span<double> q, std::span<double> v) const override;
  void apply_mass(std::span<const double> x, std::span<double> y) const override;
  std::vector<int> block_sizes() const override { return std::vector<int>(rest_.size(), 6); }
  void filter(std::span<double> x) const override;
  /// Of the centres: a spinning ball occupies the same space.
  double relative_speed_bound(int p, std::span<const double> v) const override;
  void motion_clusters(int p, std::span<const double> v, std::vector<MotionCluster>& out) const override;
  void finer_clusters(int p, std::size_t cluster, std::span<const double> v,
                      std::vector<MotionCluster>& out) const override;
  bool meets_itself() const override { return true; }
  double kinetic_energy(std::span<const double> v) const override;
  Vec3 linear_momentum(std::span<const double> v) const override;
  Vec3 angular_momentum(std::span<const double> v) const override;
  bool rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const override;

  void add_forces(const Environment& env, std::span<double> Q) const override;
  void apply_stiffness(std::span<const double> x, std::span<double> y) const override;
  void apply_damping(std::span<const double> x, std::span<double> y) const override;
  void begin_solve(double dt) override;
  bool foresee(std::span<const double> v) override;
  void apply_system(std::span<const double> x, std::span<double> y) const override;
  std::optional<BlockSystem> block_system() const override { return std::nullopt; }  // blocks are of six
  SixCouplings couplings() const override;
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override;

  std::span<const double> radii() const { return radius_; }
  const GrainPairs& pairs() const { return pairs_; }

 protected:
  void add_inner() override;

 private:
  PointsBody(std::vector<Vec3> centers, std::vector<double> radius, const PointsOptions& options);
  /// y += factor times the rolling resistance on fixed parts.
  void add_rolling(double factor, std::span<const double> x, std::span<double> y) const;
  void filter_spin(std::span<double> x) const;
  /// y += factor M x.
  void add_mass(double factor, std::span<const double> x, std::span<double> y) const;
  /// Largest gap of grains that can meet within a step, [m]. @param v  [m/s] of the centres
  double gap_for(double dt, std::span<const Vec3> v) const;
  /// Finds the pairs within a gap and their forces in the step to come.
  void find_pairs(double gap);
  /// Takes over the forces of the pairs.
  void gather_pairs();

  std::vector<double> radius_;  // [m], per grain
  double smallest_, largest_;   // [m] of them
  ParticleCells cells_;         // of the last update
  GrainMaterial material_;
  GrainPairs pairs_;
  bool turn_ = true;
  std::vector<std::int32_t> given_;             // triples with prescribed velocity, SixCouplings::prescribed
  std::vector<double> load_, roll_;             // [N] from fixed parts; [N m s] their resistance to spin
  std::vector<double> inertia_;                 // [kg m²], per grain
  std::vector<Vec3> spin_;                      // [rad/s], of the last update
  std::vector<Vec3> pair_force_, pair_torque_;  // [N], [N m], with damping and friction
};

}  // namespace brim
