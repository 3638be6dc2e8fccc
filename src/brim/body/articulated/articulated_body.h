#pragma once

#include "brim/body/aimed_drives.h"
#include "brim/body/articulated/joint_forces.h"
#include "brim/body/articulated/tree_flow.h"
#include "brim/body/articulated/tree_map.h"
#include "brim/body/distance_bound.h"
#include "brim/body/foresees_contact.h"
#include "brim/body/mass_center.h"
#include "brim/body/movable.h"
#include "brim/body/movable_base.h"
#include "brim/body/outer_forces.h"
#include "brim/body/posed_display.h"
#include "brim/body/posed_shape.h"
#include "brim/body/restless.h"
#include "brim/body/turns.h"
#include "brim/core/workspace_pool.h"

namespace brim {

/// Links connected to a tree, in the coordinates of its joints (JointKind gives their numbers), link after link. Every
/// solid on a link is a part. Links connected by a joint never touch each other.
///
/// The common solve handles weight, drives, limits, damping and friction; Coriolis and centrifugal terms act in
/// finish_step, where the tree moves freely for the step (TreeFlow).
class ArticulatedBody final : public Body,
                              public DistanceBound,
                              public PosedDisplay,
                              public OuterForces,
                              public Turns,
                              public Restless,
                              public Movable,
                              public AimedDrives,
                              public MassCenter,
                              public MovableBase,
                              public ForeseesContact {
 public:
  /// @throws InputError as Tree does, and for a joint that moves no mass
  explicit ArticulatedBody(ArticulatedModel model);

  std::string_view kind() const override { return "articulated"; }
  std::size_t q_size() const override { return tree_.q_size(); }
  std::size_t v_size() const override { return tree_.v_size(); }
  void initial_state(std::span<double> q, std::span<double> v) const override;
  void update(double time, std::span<const double> q, std::span<const double> v) override;
  /// Along straight joint coordinates; finish_step replaces it by the free motion, and keeps displacements not along v.
  void advance(double dt, std::span<double> q, std::span<const double> v) const override { tree_.move(dt, v, q); }
  void finish_step(double time, double dt, std::span<double> q, std::span<double> v) override;
  /// The free root carries all links: its coordinates are the first, in the world frame.
  void move(const Pose& by, std::span<double> q, std::span<double> v) const override { move_frame(by, q, v); }
  const char* bound() const override { return tree_.floating() ? "" : "is fixed to the world by its base"; }
  const char* refuses_turn(const Mat3&) const override {
    return tree_.has_free() ? "has a free joint beside others that join it to the world" : "";
  }
  void set_base(const Pose& from_start) override { tree_.set_base(from_start); }

  void add_forces(const Environment& env, std::span<double> Q) const override;
  void apply_mass(std::span<const double> x, std::span<double> y) const override;
  void apply_stiffness(std::span<const double> x, std::span<double> y) const override;
  void apply_damping(std::span<const double> x, std::span<double> y) const override;
  void begin_solve(double dt) override;
  void apply_system(std::span<const double> x, std::span<double> y) const override;
  /// One block per movable joint.
  std::vector<int> block_sizes() const override { return tree_.block_sizes(); }
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override;
  /// Exact inverse of A plus the contacts of each link taken separately: the articulated-body algorithm.
  void prepare_preconditioner(std::size_t first, const BlockDiagonal& D) override;
  void precondition(std::size_t first, const BlockDiagonal& D, std::span<const double> r,
                    std::span<double> z) const override;

  int part_count() const override { return static_cast<int>(parts_.size()); }
  PartInfo part(int p) const override { return parts_[p].info; }
  bool parts_collide(int p, int q) const override;
  Aabb bounds(int p) const override { return parts_[p].solid.bounds(); }
  Vec3 mean_velocity(int p, std::span<const double> v) const override;
  double relative_speed_bound(int p, std::span<const double> v) const override;
  void presence(int p, double h, double w, const Aabb& region, std::vector<TileKey>& out) const override {
    parts_[p].solid.presence(h, w, region, out);
  }
  double distance_bound(int p, const Vec3& x) const override { return parts_[p].solid.distance_bound(x); }
  const PosedShape* solid(int p) const override { return &parts_[p].solid; }
  void rasterize(int p, double h, double w, std::span<const TileKey> tiles,
                 std::span<DensityBlock> out) const override {
    parts_[p].solid.rasterize(h, w, tiles, out);
  }
  void make_map(int p, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;

  /// Of all links, those that are fixed to the world included; so is the centre.
  double mass() const override { return tree_.total_mass(); }
  Vec3 mass_center() const override { return tree_.mass_center(pose_); }
  double potential_energy(const Environment& env) const override;
  Vec3 linear_momentum(std::span<const double> v) const override { return momentum(v).head<3>(); }
  Vec3 angular_momentum(std::span<const double> v) const override { return momentum(v).tail<3>(); }
  bool rigid_motion(const Vec3& t, const Vec3& w, std::span<double> v) const override;

  void turns(std::span<const double> v, std::span<Turn> part) const override;

  const Display& display() const override { return display_; }
  void display_positions(std::span<Vec3f> x) const override;
  std::size_t piece_count() const override { return parts_.size(); }
  const PosedShape& piece(std::size_t i) const override { return parts_[i].solid; }

  /// Lets go of limits from which the last solve takes their joints away.
  bool foresee(std::span<const double> v) override { return joints_.release(tree_, v); }

  /// True when a joint has a motor.
  bool restless() const override { return joints_.driven(); }

  const Tree& tree() const { return tree_; }
  /// Of the last update.
  const TreePose& pose() const { return pose_; }
  /// Names of the links, and of the joints above them: that of the link where a joint has none. Shape: (links)
  std::span<const std::string> link_names() const { return link_names_; }
  std::span<const std::string> joint_names() const { return joint_names_; }
  /// Drives of revolute and prismatic joints. Those of ball joints aim at rest.
  std::span<const std::string> drive_names() const override { return drive_names_; }
  void aim_drive(std::size_t drive, const std::optional<DriveAim>& aim) override;
  /// Link above which a drive is.
  int driven_link(std::size_t drive) const { return drives_[drive].link; }
  /// What a drive applies along its joint in a state [N m or N]: at a time [s] as at the end of a step.
  double drive_effort(std::size_t drive, double time, std::span<const double> q, std::span<const double> v) const;
  /// Velocity of a link's origin and its angular velocity, world frame, for the pose of the last update.
  Vec6 link_twist(int link, std::span<const double> v) const;
  /// Lower and upper limit of the joint above a link, [rad or m]; infinite: none.
  std::pair<double, double> joint_range(int link) const { return joints_.range(static_cast<std::size_t>(link)); }
  /// Drive of the joint above a link; may be changed between steps.
  JointDrive& drive(int link) { return joints_.drive(static_cast<std::size_t>(link)); }
  const JointDrive& drive(int link) const { return joints_.drive(static_cast<std::size_t>(link)); }

 private:
  struct Part {
    PosedShape solid;
    int link;
    Pose local;  ///< from the shape's to the link's frame
    PartInfo info;
    Vec3 middle;       ///< [m] centre of its box, link's frame: its velocity is the part's mean
    double reach = 0;  ///< [m] distance of the farthest point from there
    std::size_t first_vertex = 0;
  };
  struct Scratch {
    std::vector<Vec6> a;
    std::vector<Mat6> inertia;
  };

  /// A drive that can be aimed, as described.
  struct Drive {
    int link = 0;
    JointDrive given;
  };

  void name_all(const ArticulatedModel& model);
  void make_parts(ArticulatedModel& model);
  void group_links(const ArticulatedModel& model);
  Vec6 momentum(std::span<const double> v) const;

  /// Moves joints back from beyond their limits, as the solve had it, without the velocity of that.
  void return_from_limits(double dt, std::span<double> q, std::span<double> v);

  Tree tree_;
  JointForces joints_;
  JointStops stops_;
  TreeFlow flow_;
  std::vector<Part> parts_;
  Display display_;
  std::vector<double> start_q_, start_v_;
  std::vector<std::string> link_names_, joint_names_, drive_names_;
  std::vector<Drive> drives_;
  bool self_collision_;
  std::vector<int> group_;                  ///< per link: links connected by fixed joints form a group
  std::vector<std::pair<int, int>> apart_;  ///< groups that never touch, sorted
  std::unique_ptr<TreeContact> contact_ = std::make_unique<TreeContact>();  ///< written by the maps
  mutable WorkspacePool<Scratch> scratch_;
  // Of the last update:
  double time_ = 0.0;
  std::vector<double> q_, v_;
  TreePose pose_;
  TreeInverse free_inverse_;  ///< of M alone
  std::vector<Mat3> none_;
  // Of the solve:
  TreeInverse inverse_;
  std::vector<Mat3> joint_terms_;
  bool inverse_good_ = false;
};

}  // namespace brim
