#pragma once

#include "brim/body/body.h"
#include "brim/body/distance_bound.h"
#include "brim/body/known_volume.h"
#include "brim/body/movable.h"
#include "brim/body/outer_forces.h"
#include "brim/body/posed_display.h"
#include "brim/body/posed_shape.h"
#include "brim/body/rigid_frame.h"
#include "brim/body/turns.h"

namespace brim {

/// Properties of a rigid body. The body's frame has its origin at the centre of mass.
struct RigidModel {
  std::string kind = "rigid";            ///< the body's keyword in scenes and reports
  std::shared_ptr<const Shape> shape;    ///< solid, in the shape's own frame
  Vec3 center_of_mass = Vec3::Zero();    ///< [m] in the shape's frame
  double mass = 1.0;                     ///< [kg]
  double volume = 0.0;                   ///< [m³] 0: unknown; told, not used
  Mat3 inertia = Mat3::Identity();       ///< [kg m²] about the centre of mass, shape's axes
  Vec3 position = Vec3::Zero();          ///< [m] initial position of the shape's origin
  Quat rotation = Quat::Identity();      ///< initial, from the shape's frame to the world
  Vec3 velocity = Vec3::Zero();          ///< [m/s] initial, of the centre of mass
  Vec3 angular_velocity = Vec3::Zero();  ///< [rad/s] initial, world frame
  double linear_damping = 0.0;           ///< [1/s] drag proportional to momentum
  double angular_damping = 0.0;          ///< [1/s]
  PartInfo part;
  Shared<TriMesh> surface;  ///< for display, shape's frame
};

/// Rigid body: q = (position of the centre of mass, quaternion w x y z), v = (o', ω), world frame.
/// Free rotation conserves angular momentum exactly: after each step ω follows from L at the new orientation.
class RigidBody final : public Body,
                        public DistanceBound,
                        public RigidFrame,
                        public Turns,
                        public PosedDisplay,
                        public OuterForces,
                        public Movable,
                        public KnownVolume {
 public:
  /// @throws InputError without a shape, when mass or inertia is not that of a solid, and for numbers that are not
  /// finite
  explicit RigidBody(RigidModel model);

  std::string_view kind() const override { return model_.kind; }
  std::size_t q_size() const override { return 7; }
  std::size_t v_size() const override { return 6; }
  void initial_state(std::span<double> q, std::span<double> v) const override;
  void update(double time, std::span<const double> q, std::span<const double> v) override;
  void advance(double dt, std::span<double> q, std::span<const double> v) const override;
  void finish_step(double time, double dt, std::span<double> q, std::span<double> v) override;
  void move(const Pose& by, std::span<double> q, std::span<double> v) const override { move_frame(by, q, v); }

  void add_forces(const Environment& env, std::span<double> Q) const override;
  void apply_mass(std::span<const double> x, std::span<double> y) const override;
  void apply_damping(std::span<const double> x, std::span<double> y) const override;
  std::vector<int> block_sizes() const override { return {6}; }
  void apply_system(std::span<const double> x, std::span<double> y) const override;
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override;

  PartInfo part(int) const override { return model_.part; }
  Aabb bounds(int) const override { return solid_.bounds(); }
  Vec3 mean_velocity(int, std::span<const double> v) const override { return {v[0], v[1], v[2]}; }
  double relative_speed_bound(int, std::span<const double> v) const override;
  void presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const override {
    solid_.presence(h, w, region, out);
  }
  double distance_bound(int, const Vec3& x) const override { return solid_.distance_bound(x); }
  const PosedShape* solid(int) const override { return &solid_; }
  void rasterize(int, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const override {
    solid_.rasterize(h, w, tiles, out);
  }
  void make_map(int, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;

  double mass() const override { return model_.mass; }
  double volume() const override { return model_.volume; }
  double potential_energy(const Environment& env) const override;
  Vec3 linear_momentum(std::span<const double> v) const override;
  Vec3 angular_momentum(std::span<const double> v) const override;

  Frame rigid_frame() const override;
  void turns(std::span<const double> v, std::span<Turn> part) const override {
    part[0] = {.center = center_, .spin = {v[3], v[4], v[5]}};
  }
  bool rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const override;

  const Display& display() const override { return display_; }
  void display_positions(std::span<Vec3f> x) const override { solid_.display_positions(x); }
  std::size_t piece_count() const override { return 1; }
  const PosedShape& piece(std::size_t) const override { return solid_; }

 private:
  RigidModel model_;
  PosedShape solid_;
  Display display_;
  double reach_ = 0.0;  ///< [m] distance of the farthest point from the centre of mass
  Mat3 model_inverse_;  ///< of the inertia, shape's axes, [1/(kg m²)]
  // Of the last update:
  Vec3 center_ = Vec3::Zero();                                    ///< [m] centre of mass
  Mat3 inertia_ = Mat3::Identity();                               ///< world axes, [kg m²]
  Mat3 inverse_inertia_ = Mat3::Identity();                       ///< world axes, [1/(kg m²)]
  Vec3 momentum_rate_ = Vec3::Zero(), spin_rate_ = Vec3::Zero();  ///< damping forces
};

}  // namespace brim
