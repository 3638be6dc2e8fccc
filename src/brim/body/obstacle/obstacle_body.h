#pragma once

#include "brim/body/body.h"
#include "brim/body/distance_bound.h"
#include "brim/body/kinematic.h"
#include "brim/body/movable.h"
#include "brim/body/posed_display.h"
#include "brim/body/posed_shape.h"
#include "brim/body/rigid_frame.h"
#include "brim/body/turns.h"

namespace brim {

/// Pose key of an animated obstacle.
struct PoseKey {
  double time = 0.0;             ///< [s]
  Vec3 position = Vec3::Zero();  ///< [m] of the shape's origin
  Quat rotation = Quat::Identity();
};

struct ObstacleModel {
  std::shared_ptr<const Shape> shape;
  /// One key: static. More: linear positions and spherical rotations between keys, constant outside; times increase.
  std::vector<PoseKey> keys = {PoseKey{}};
  PartInfo part;
  Shared<TriMesh> surface;  ///< for display, shape's frame
};

/// Static, animated or driven (Kinematic) rigid solid of infinite mass. q and v are those of a rigid body (origin of
/// the shape); all of v is prescribed, so the solver has no unknowns.
class ObstacleBody final : public Body,
                           public DistanceBound,
                           public RigidFrame,
                           public Turns,
                           public PosedDisplay,
                           public Movable,
                           public Kinematic {
 public:
  /// @throws InputError when keys are missing or their times do not increase
  explicit ObstacleBody(ObstacleModel model);

  std::string_view kind() const override { return "obstacle"; }
  std::size_t q_size() const override { return 7; }
  std::size_t v_size() const override { return 6; }
  void initial_state(std::span<double> q, std::span<double> v) const override;
  void prescribe(double time, double dt, std::span<const double> q, std::span<double> v) const override;
  void update(double time, std::span<const double> q, std::span<const double> v) override;
  void advance(double dt, std::span<double> q, std::span<const double> v) const override;
  void move(const Pose& by, std::span<double> q, std::span<double> v) const override { move_frame(by, q, v); }
  bool driven() const override { return animated() && !motion_; }
  void set_motion(const std::optional<KinematicMotion>& motion) override { motion_ = motion; }

  void add_forces(const Environment&, std::span<double>) const override {}
  void apply_mass(std::span<const double> x, std::span<double> y) const override;
  void apply_system(std::span<const double> x, std::span<double> y) const override { apply_mass(x, y); }
  std::vector<int> block_sizes() const override { return {6}; }
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override;
  void filter(std::span<double> x) const override { std::fill(x.begin(), x.end(), 0.0); }

  PartInfo part(int) const override { return model_.part; }
  bool immobile() const override { return true; }
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

  double mass() const override { return std::numeric_limits<double>::infinity(); }
  double kinetic_energy(std::span<const double>) const override { return 0.0; }
  double potential_energy(const Environment&) const override { return 0.0; }
  Vec3 linear_momentum(std::span<const double>) const override { return Vec3::Zero(); }
  Vec3 angular_momentum(std::span<const double>) const override { return Vec3::Zero(); }

  Frame rigid_frame() const override { return {solid_.pose().translation, 0.0, Mat3::Zero()}; }
  void turns(std::span<const double> v, std::span<Turn> part) const override {
    part[0] = {.center = solid_.pose().translation, .spin = {v[3], v[4], v[5]}};
  }

  const Display& display() const override { return display_; }
  void display_positions(std::span<Vec3f> x) const override { solid_.display_positions(x); }
  std::size_t piece_count() const override { return 1; }
  const PosedShape& piece(std::size_t) const override { return solid_; }
  /// True when it has more than one key.
  bool animated() const { return model_.keys.size() > 1; }

 private:
  ObstacleModel model_;
  PosedShape solid_;
  Display display_;
  std::optional<KinematicMotion> motion_;  // in place of the keys
  double reach_ = 0.0;
};

}  // namespace brim
