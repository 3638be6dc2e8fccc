#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/body/guided_particles.h"
#include "brim/body/keeps_energy.h"
#include "brim/body/meets_itself.h"
#include "brim/body/movable.h"
#include "brim/body/octant_presence.h"
#include "brim/body/outer_forces.h"
#include "brim/body/particles/body_pieces.h"
#include "brim/body/particles/element_clusters.h"
#include "brim/body/particles/mean_motion.h"
#include "brim/body/particles/particle_contact.h"
#include "brim/body/turns.h"
#include "brim/math/block_matrix.h"

namespace brim {

/// Particles with prescribed positions over time.
struct NodeMotion {
  std::vector<std::int32_t> nodes;
  /// Position at `time` [s] of a node whose rest position is `rest` [m].
  std::function<Vec3(double time, const Vec3& rest)> position;

  /// The nodes move at a constant velocity [m/s] from time 0.
  static NodeMotion constant_velocity(std::vector<std::int32_t> nodes, const Vec3& velocity);
};

/// Options common to bodies of particles.
struct ParticleOptions {
  double mass_damping = 0.0;       ///< [1/s] force −a M v (Rayleigh), >= 0
  double stiffness_damping = 0.0;  ///< [s] force −b K v (Rayleigh), >= 0; about 2 dt damps contact well
  std::vector<std::int32_t> fixed;
  std::vector<NodeMotion> motions;       ///< a node may be in only one of them, and not fixed
  Vec3 initial_velocity = Vec3::Zero();  ///< [m/s]
  Vec3 initial_spin = Vec3::Zero();      ///< [rad/s] about the centre of mass
  double voxel_size = 0.0;               ///< [m] grid step for contact; 0 lets the body choose
  bool self_contact = false;             ///< sheets and lines: the body touches itself (BodyPieces)
  Material material;
};

/// Body of particles with three coordinates each: q are positions [m], v velocities [m/s], mass lumped at particles.
/// Internal forces f(x) and their stiffness K(x) (positive semi-definite) come from the derived kind; this class adds
/// gravity, Rayleigh damping −(a M + b K) v, prescribed nodes, and the system of the implicit step
///   A = (1 + dt a) M + (dt b + dt²) K
/// K in the damping is that of the current state; its change with q is neglected in ∂Q/∂q. Contact is delegated to a
/// ParticleContact, which the derived kind passes to set_contact.
class ParticleBody : public Body,
                     public MotionClusters,
                     public OctantPresence,
                     public OuterForces,
                     public Movable,
                     public GuidedParticles,
                     public KeepsEnergy,
                     public MeetsItself,
                     public Turns {
 public:
  std::size_t q_size() const override { return 3 * rest_.size(); }
  std::size_t v_size() const override { return 3 * rest_.size(); }
  void initial_state(std::span<double> q, std::span<double> v) const override;
  void prescribe(double time, double dt, std::span<const double> q, std::span<double> v) const override;
  void update(double time, std::span<const double> q, std::span<const double> v) override;
  void advance(double dt, std::span<double> q, std::span<const double> v) const override;
  void move(const Pose& by, std::span<double> q, std::span<double> v) const override { move_points(by, q, v); }
  bool driven() const override { return !options_.motions.empty(); }

  /// Restores the momentum of free motion lost in the step (docs/numerics.md, Momentum of deformable bodies).
  void finish_step(double time, double dt, std::span<double> q, std::span<double> v) override;
  void keep_energy(double time, std::span<const double> q, std::span<double> v) override;

  void add_forces(const Environment& env, std::span<double> Q) const override;
  void apply_mass(std::span<const double> x, std::span<double> y) const override;
  void apply_stiffness(std::span<const double> x, std::span<double> y) const override;
  void set_guided(std::span<const std::uint8_t> guided) override { guided_.assign(guided.begin(), guided.end()); }
  void set_linked(std::span<const std::uint8_t> linked) override { linked_.assign(linked.begin(), linked.end()); }
  void apply_start_stiffness(std::span<const double> x, std::span<double> y) const override;
  void apply_damping(std::span<const double> x, std::span<double> y) const override;
  void apply_system(std::span<const double> x, std::span<double> y) const override;
  std::optional<BlockSystem> block_system() const override;
  std::vector<int> block_sizes() const override { return std::vector<int>(rest_.size(), 3); }
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override;
  void filter(std::span<double> x) const override;

  bool immobile() const override { return prescribed_.size() == rest_.size() && options_.motions.empty(); }
  PartInfo part(int) const override { return part_; }
  Aabb bounds(int p) const override;
  void presence(int p, double h, double w, const Aabb& region, std::vector<TileKey>& out) const override;
  void octant_presence(int p, double h, double w, const Aabb& region, std::vector<OctantTile>& out) const override;
  void rasterize(int p, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const override;
  void make_map(int p, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;
  const Body* pieces() const override { return pieces_.get(); }
  std::int32_t source_of(int piece, std::int32_t source) const override { return pieces_->source_of(piece, source); }
  bool may_meet(std::int32_t source, std::int32_t other) const override { return pieces_->may_meet(source, other); }
  Vec3 mean_velocity(int p, std::span<const double> v) const override;
  double relative_speed_bound(int p, std::span<const double> v) const override;
  void motion_clusters(int p, std::span<const double> v, std::vector<MotionCluster>& out) const override;
  void finer_clusters(int p, std::size_t cluster, std::span<const double> v,
                      std::vector<MotionCluster>& out) const override;

  double mass() const override;
  double kinetic_energy(std::span<const double> v) const override;
  double potential_energy(const Environment& env) const override;
  Vec3 linear_momentum(std::span<const double> v) const override;
  Vec3 angular_momentum(std::span<const double> v) const override;
  bool rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const override;
  void turns(std::span<const double> v, std::span<Turn> part) const override;

  /// The particles themselves; kinds with another display override both functions.
  const Display& display() const override { return display_; }
  void display_positions(std::span<Vec3f> x) const override;

  // ---- for tests, tools and derived kinds ------------------------------------------------------------------------
  std::size_t particle_count() const { return rest_.size(); }
  std::span<const Vec3> rest_positions() const { return rest_; }
  std::span<const double> masses() const { return mass_; }
  std::span<const Vec3> positions() const { return x_; }
  /// Internal elastic forces of the last updated state, [N], shape (particles).
  std::span<const Vec3> inner_forces() const { return force_; }
  const BlockMatrix& stiffness() const { return stiffness_; }
  /// Elastic energy of the last updated state, [J].
  virtual double elastic_energy() const = 0;

 protected:
  /// @param rest  [m] positions of the particles  @param mass  [kg] of each
  /// @throws InputError  when an option is out of range or names a node that does not exist
  ParticleBody(std::vector<Vec3> rest, std::vector<double> mass, ParticleOptions options);
  /// Adds the internal forces of positions_ to force_ and −∂f/∂x, projected to be positive semi-definite, to
  /// stiffness_.
  virtual void add_inner() = 0;
  /// Empties what add_inner fills, and ends the filling.
  virtual void begin_inner();
  virtual void end_inner();
  /// y += G x, G: geometric stiffness (rotation of the tension) between particles that are both guided; for kinds that
  /// have it.
  virtual void add_turning_stiffness(std::span<const double> x, std::span<const std::uint8_t> guided,
                                     std::span<double> y) const {
    (void)x, (void)guided, (void)y;
  }
  /// Correction of the positions after a step of dt; null: none.
  virtual Straighten straightening(double dt) const {
    (void)dt;
    return {};
  }
  /// Sets the body's contact and its parameters. The options' voxel size and material override those given, and so does
  /// an areal mass of 0 for a body without free particles.
  /// @throws InputError  for self-contact of a body that is neither a sheet nor a line
  void set_contact(std::unique_ptr<const ParticleContact> contact, PartInfo part);

  std::vector<Vec3> rest_;
  std::vector<double> mass_;
  ParticleOptions options_;
  std::vector<std::int32_t> prescribed_;  // fixed and moved nodes, sorted
  double least_inertia_ = ParticleSet().least_inertia;
  ParticleSet particle_set() const { return {mass_, prescribed_, least_inertia_}; }
  std::vector<Vec3> x_, v_, force_;  // of the last update
  BlockMatrix stiffness_;
  std::vector<std::uint8_t> linked_;  // in this step, or empty
  Display display_;

 private:
  double total_mass_ = 0.0;           // [kg]
  Aabb box_;                          // of x_
  bool ahead_ = false;                // keep_energy has updated to x_: the next update finds it done
  std::vector<double> impulse_;       // [N s] scratch of finish_step
  std::vector<std::uint8_t> guided_;  // in this step, or empty
  std::unique_ptr<const ParticleContact> contact_;
  ElementClusters clusters_;
  std::unique_ptr<BodyPieces> pieces_;  // of a body that touches itself
  PartInfo part_;
};

/// Throws InputError for a number out of range: "cloth: thickness is -1; it must be positive".
void require_positive(const char* what, const char* name, double value);
void require_not_negative(const char* what, const char* name, double value);

}  // namespace brim
