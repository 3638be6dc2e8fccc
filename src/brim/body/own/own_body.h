#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "brim/body/body.h"
#include "brim/body/material_points.h"
#include "brim/body/outer_forces.h"
#include "brim/body/particles/mean_motion.h"
#include "brim/body/time_driven.h"
#include "brim/body/turns.h"
#include "brim/map/dense_map.h"

namespace brim {

/// Initial state and material of an own body.
struct OwnModel {
  std::vector<double> q;           ///< coordinates at the start, any units, shape (n)
  std::vector<double> v;           ///< dq/dt at the start, shape (n); empty: at rest
  TriMesh surface;                 ///< [m] at rest, closed: the material, for mass and display
  double density = 1000.0;         ///< [kg/m³]
  double mass_spacing = 0.0;       ///< [m] between the mass points; 0: an eighth of the extent
  double stiffness_damping = 0.0;  ///< [s] Rayleigh damping of stiffness
  double voxel_size = 0.0;         ///< [m] 0: an eighth of the smallest extent
  Material material;
};

/// Base class for user-defined bodies with a few coordinates q: the author gives only the deformation, the distance to
/// the surface, and the energy; contact and solver data are derived (docs/bodies/your_own.md):
///   J = ∂deform/∂q,  M = Σ m JᵀJ,  Q = −∂E/∂q + Σ m Jᵀ g − Σ m Jᵀ J̇ v,  K = −∂²E/∂q² without its positive part
/// with derivatives by central differences unless overridden, and sums over mass points of the rest shape. Differences
/// move matter by 1e-5 to 1e-3 of its extent, whatever the units of q: an energy that varies on that scale needs its
/// own energy_force.
/// All costs grow with n² or n³: for up to some dozens of coordinates.
///
/// Momentum of contact is exact as far as deform() can represent rigid motion: translations give exact linear momentum,
/// rotations exact angular momentum. A body with both moves as the built-in deformable kinds do: its matter turns with
/// its mean motion, and then the coordinates and velocities nearest to it are taken (least squares over the mass
/// points; there is no J̇ v then). If the energy is invariant under rotation, the spin lost by linearising its forces
/// over a step is given back (docs/numerics.md, Momentum of deformable bodies). Tests: tests/body/own_body_test.cpp
class OwnBody : public Body, public OuterForces, public MaterialPoints, public Turns, public TimeDriven {
 public:
  using Coordinates = std::span<const double>;
  using Jacobian = DenseMap::Jacobian;

  // ---- to be overridden; called from several threads ---------------------------------------------------------------
  /// Position of the material at X at rest, [m].
  virtual Vec3 deform(Coordinates q, const Vec3& X) const { return place(q, X); }
  /// The inverse: rest position of the material at x, [m]; needed within half a ramp of the surface.
  virtual Vec3 inverse_deform(Coordinates q, const Vec3& x) const { return rest(q, x); }
  /// Signed distance from x to the surface, negative inside, [m]; needed within half a ramp of the surface (1.5 of its
  /// voxels, WorldOptions::ramp_voxels), elsewhere only its sign.
  virtual double distance(Coordinates q, const Vec3& x) const = 0;
  /// Elastic or other internal energy, [J].
  virtual double energy(Coordinates q) const { return static_cast<void>(q), 0.0; }
  /// ∂deform/∂q, shape (3, n). The default takes central differences. At the start it is compared with differences at a
  /// few points.
  virtual void jacobian(Coordinates q, const Vec3& X, Eigen::Ref<Jacobian> J) const;
  /// −∂E/∂q, shape (n). The default takes central differences.
  virtual Eigen::VectorXd energy_force(Coordinates q) const;

  /// The former names of deform and inverse_deform, for existing bodies.
  /// @throws InputError  when a body overrides neither
  virtual Vec3 place(Coordinates q, const Vec3& X) const;
  virtual Vec3 rest(Coordinates q, const Vec3& x) const;

  // ---- the same for many points, for authors who work on arrays; the defaults go point by point --------------------
  virtual void deform_all(Coordinates q, std::span<const Vec3> X, std::span<Vec3> x) const;
  virtual void inverse_deform_all(Coordinates q, std::span<const Vec3> x, std::span<Vec3> X) const;
  /// @param J  allocated for X.size() points and n coordinates
  virtual void jacobian_all(Coordinates q, std::span<const Vec3> X, DenseMap& J) const;

  // ---- derived -----------------------------------------------------------------------------------------------------
  std::size_t q_size() const override { return model_.q.size(); }
  std::size_t v_size() const override { return model_.q.size(); }
  void initial_state(std::span<double> q, std::span<double> v) const override;
  void update(double time, std::span<const double> q, std::span<const double> v) override;
  bool changes(double from, double to, std::span<const double> q) override;
  void advance(double dt, std::span<double> q, std::span<const double> v) const override;
  void finish_step(double time, double dt, std::span<double> q, std::span<double> v) override;
  void add_forces(const Environment& env, std::span<double> Q) const override;
  void apply_mass(std::span<const double> x, std::span<double> y) const override;
  void apply_stiffness(std::span<const double> x, std::span<double> y) const override;
  void apply_damping(std::span<const double> x, std::span<double> y) const override;
  std::vector<int> block_sizes() const override { return {static_cast<int>(model_.q.size())}; }
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override;
  PartInfo part(int) const override { return part_; }
  Aabb bounds(int) const override { return bounds_; }
  Vec3 mean_velocity(int, std::span<const double> v) const override { return linear_momentum(v) / mass_; }
  double relative_speed_bound(int, std::span<const double> v) const override;
  void presence(int p, double h, double w, const Aabb& region, std::vector<TileKey>& out) const override;
  void rasterize(int p, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const override;
  void make_map(int p, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;
  void turns(std::span<const double> v, std::span<Turn> part) const override;
  Vec3 material_at(int, const Vec3& x) const override;
  Vec3 position_of(int, const Vec3& X) const override;
  double mass() const override { return mass_; }
  double potential_energy(const Environment& env) const override;
  Vec3 linear_momentum(std::span<const double> v) const override;
  Vec3 angular_momentum(std::span<const double> v) const override;
  bool rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const override;
  const Display& display() const override { return display_; }
  void display_positions(std::span<Vec3f> x) const override;

 protected:
  /// @throws InputError  for a surface that is not closed, numbers that are not finite, sizes that do not fit
  explicit OwnBody(OwnModel model);
  /// Of the last update.
  Coordinates coordinates() const { return q_; }
  /// [units of q] step of a central difference of deform in coordinate i: it moves matter by 1e-4 of its extent.
  double place_step(std::size_t i) const;
  /// True when errors of the author's functions name body and function already (a binding to another language).
  virtual bool errors_are_named() const { return false; }

 private:
  friend class OwnBodyCheck;
  // The author's functions, asked (ask_author.cpp): what they throw or give wrongly becomes an InputError with the
  // names of body and function, the time and the coordinates.
  void ask_deform(Coordinates q, std::span<const Vec3> X, std::span<Vec3> x) const;
  void ask_inverse_deform(Coordinates q, std::span<const Vec3> x, std::span<Vec3> X) const;
  void ask_jacobian(Coordinates q, std::span<const Vec3> X, DenseMap& J) const;
  double ask_distance(Coordinates q, const Vec3& x) const;
  double ask_energy(Coordinates q) const;
  Eigen::VectorXd ask_force(Coordinates q) const;
  template <class F>
  auto ask(const char* function, Coordinates q, const F& f) const;
  [[noreturn]] void refuse(const char* function, Coordinates q, const std::string& what) const;
  /// Asks distance and inverse_deform once and looks for coordinates without effect, so that errors do not wait for the
  /// first contact. @throws InputError
  void check_start() const;
  void measure_scales();
  /// @throws InputError  when the jacobian is not the derivative of deform
  void check_jacobian() const;
  void measure_matter();
  /// Σ m Jᵀ J̇ v
  Eigen::VectorXd bias() const;
  /// −Σ m Jᵀ J̇ v, or the forces of the frame that turns with the body.
  void add_forces_of_motion(std::span<double> Q) const;
  /// Whether coordinates can move all matter as one rigid body.
  bool follows_rigid_motion() const;
  /// Whether the energy is the same after a turn about the centre of mass.
  bool is_energy_turned() const;
  ParticleSet pieces() const { return {.mass = piece_mass_, .prescribed = {}}; }
  /// Of the pieces, shape (3 pieces).
  std::vector<double> piece_places(Coordinates q) const;
  std::vector<double> piece_velocities(std::span<const double> v) const;
  /// Σ m Jᵀ J over the pieces.
  Eigen::MatrixXd mass_matrix(const DenseMap& J) const;
  /// Σ m Jᵀ u over the pieces. @param u  shape (3 pieces)
  Eigen::VectorXd gather(const DenseMap& J, std::span<const double> u) const;
  /// Moves q to the coordinates whose matter is nearest to x. @param x  [m] of the pieces, shape (3 pieces)
  /// @return false when there are none near q, which is kept
  bool fit(std::span<const double> x, std::span<double> q) const;
  /// [units of q] step of coordinate i for a central difference.
  double step_of(std::size_t i, double relative) const;
  /// [s] time in which motion at v moves matter by such a step.
  double time_step(std::span<const double> v) const;
  void measure_energy();

  OwnModel model_;
  PartInfo part_;
  Display display_;
  std::vector<Vec3> piece_;         // [m] at rest
  std::vector<double> piece_mass_;  // [kg]
  double mass_ = 0.0;
  // Of the first update:
  std::vector<double> scale_;  // [units of q] that move matter by the extent at rest
  bool started_ = false;
  bool rigid_ = false;         // coordinates can move it as a rigid body
  bool turns_freely_ = false;  // and its energy is invariant under rotation
  // Of the last update:
  double now_ = 0.0;  // [s]
  std::vector<double> q_, v_;
  std::vector<Vec3> vertex_;
  Aabb bounds_;
  std::vector<double> x_;             // [m] of the pieces, shape (3 pieces)
  DenseMap J_;                        // of the pieces
  Vec3 first_moment_ = Vec3::Zero();  // Σ m x
  Eigen::MatrixXd M_, K_;
  Jacobian linear_, angular_;     // Σ m J and Σ m x × J
  Eigen::VectorXd force_, bias_;  // −∂E/∂q and Σ m Jᵀ J̇ v, the latter not where it is rigid_
  // Of the coordinates that the last step reached, for the next update:
  std::vector<double> next_q_, next_x_;
  DenseMap next_J_;
};

}  // namespace brim
