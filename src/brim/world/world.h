#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/step_report.h"
#include "brim/world/touch_rules.h"

namespace brim {

struct AppliedForce;  // brim/world/applied_force.h
struct Attachment;    // brim/world/attachment.h
struct Pose;          // brim/raster/shape.h
class Watcher;        // brim/world/watcher.h

/// What a pair of materials has instead of what follows from the two.
struct PairMaterial {
  double friction = -1.0;                 ///< [-] Coulomb coefficient; negative: the geometric mean of the two
  double stiffness = 0.0;                 ///< [Pa] k; 0: chosen from the loads and the softer of the two
  double restitution = -1.0;              ///< [-] e of the constraint response; negative: the larger of the two
  Response response = Response::Inherit;  ///< Inherit: what the bodies say, then the world
  double rolling_resistance = -1.0;       ///< [m] of rigid bodies; negative: the larger of the two
};

/// How the world steps. docs/numerics.md says what the choices rest on.
struct WorldOptions {
  Environment environment;
  double time_step = 1.0 / 60.0;   ///< [s] of one call of step()
  double voxel_size = 0.0;         ///< [m] h0, the finest step; 0: the finest that a part asks for
  double ramp_voxels = 3.0;        ///< ramp width over h, 2 to 4
  double stiffness = 0.0;          ///< [Pa] k; 0: chosen pair by pair, from the loads and the softer of the two
  double damping_steps = 2.0;      ///< β over dt, stiffness-proportional damping of contact
  double max_motion_voxels = 1.0;  ///< relative motion allowed in one sub-step, (0, 2]
  int max_substeps = 64;
  int min_substeps = 1;
  double cg_tolerance = 1e-4;  ///< relative residual
  int cg_max_iterations = 2000;
  int max_passes = 4;  ///< solves of a sub-step while contacts let go or friction changes
  double friction_speed =
      0.0;  ///< [m/s] ε of the regularised friction; 0: 0.001 g dt, g of the earth where there is none
  Response response = Response::Penalty;  ///< of pairs whose materials and bodies say nothing
  double constraint_tolerance = 1e-4;     ///< change of velocity by the last sweep, over that of a free fall in a step
  int constraint_sweeps = 200;            ///< most sweeps of projected Gauss-Seidel in a sub-step
  bool constraint_every_node = false;     ///< a row for every node instead of a few per patch: dear, for comparison
  bool sleep = false;         ///< leaves islands of bodies at rest out of the step until they are touched (Sleep)
  double memory_limit = 8e9;  ///< [bytes] of samples, contacts, rows and pairs, each; more is refused
  std::map<std::pair<std::string, std::string>, PairMaterial> pair_materials;  ///< by material names, sorted
  std::vector<TouchRule> touch_rules;  ///< which bodies touch; the last rule about a pair decides
};

/// The mutable truth of a world: flat arrays in body order.
struct State {
  double time = 0.0;      ///< [s]
  std::int64_t step = 0;  ///< number of steps taken
  std::vector<double> q;  ///< generalised coordinates, shape (nq)
  std::vector<double> v;  ///< generalised velocities, shape (nv)
  /// What the next step starts from besides: impulses of constraint rows, references of solids, who sleeps, links that
  /// broke, edits, levels of detail, and what watchers keep.
  std::vector<double> warm_start;
};

/// A global part: part `index` of body `body`.
struct PartRef {
  int body = 0, index = 0;
};

/// Bodies, their state, and the step that moves them (design: one step).
class World {
 public:
  explicit World(WorldOptions options = {});
  ~World();
  World(World&&) noexcept;

  /// Takes a body in; its name must be unique. @return its number
  /// @throws InputError, and what the body throws; the world is then as it was
  int add(std::unique_ptr<Body> body);
  int body_count() const;
  const Body& body(int b) const;
  int part_count() const;
  PartRef part(int p) const;
  /// Slices of the state that belong to body b.
  std::span<const double> q(int b) const;
  std::span<const double> v(int b) const;

  /// Holds a body to another one or to space, as they are now (docs/links.md). May be called between steps; a run that
  /// is resumed must have the same attachments in the same order. @return its number  @throws InputError
  int attach(const Attachment& attachment);
  int attachment_count() const;
  const Attachment& attachment(int i) const;
  /// True once it broke or was taken off; part of the state.
  bool detached(int i) const;
  void detach(int i);
  /// What the drive of a joint aims at from the next step on, [rad, m] and [rad/s, m/s]; no part of the state.
  /// @throws InputError where it has none
  void set_drive(int i, double position, double velocity);
  /// Adds what acts on bodies from outside, as they are now. @throws InputError  @return its number
  int apply(const AppliedForce& force);

  /// Takes hold of a body by a spring to a place in space, where its matter is now: of what gives way by the matter
  /// within two voxels. Whatever was held is let go. No part of the state, of reports and of records: a hand is not of
  /// the world. @param at  [m]  @param stiffness  [N/m]; 0: 3 Hz with the body's mass
  /// @param damping  [N s/m]; 0: half of critical with that mass  @throws InputError
  void grab(int b, const Vec3& at, double stiffness = 0.0, double damping = 0.0);
  /// Where the place that was taken hold of is to be from the next step on, [m]. @throws InputError
  void pull(const Vec3& to);
  void release();
  /// The body that is held so, or −1.
  int grabbed() const;

  // ---- editing, between steps (docs/editing.md): part of the state, so that a run that was edited resumes right -----
  /// Takes a body out of the world. Its number and name stay its own and those of others stay as they are; its q and v
  /// are kept as they were last. What holds to it is detached; forces on it end. @throws InputError
  void remove(int b);
  bool removed(int b) const;
  /// Makes a body stay where it is, as an obstacle would, or lets it go again, at rest.
  /// @throws InputError  for one that keyframes move
  void freeze(int b, bool frozen = true);
  bool frozen(int b) const;
  /// Sets all matter of a body from x to R x + t, and turns its velocities by R.
  /// @throws InputError  for kinds that cannot be elsewhere, what is attached, and what keyframes move
  void move(int b, const Pose& by);
  /// Gives a body the motion of a rigid one: of its centre of mass [m/s], and about it [rad/s]. @throws InputError
  void set_velocity(int b, const Vec3& velocity, const Vec3& angular_velocity);
  /// How the surface of all parts of a body behaves from now on. @throws InputError
  void set_material(int b, const Material& material);
  /// Of one part, as it is now.
  Material material(int b, int part = 0) const;
  /// Replaces what a pair of materials has, by their names. @throws InputError
  void set_pair_material(const std::string& a, const std::string& b, const PairMaterial& pair);
  /// [Pa] contact stiffness of all pairs without one of their own. @throws InputError
  void set_stiffness(double stiffness);
  /// Calls the edit at the start of the first step that begins at `at` [s] or later; no part of the state: what goes on
  /// from a later state has been edited by then. What the edit throws becomes the warning "edit_refused".
  void schedule(double at, std::function<void(World&)> edit);
  /// Says whether bodies touch, from the next step on, over all that was said before. @throws InputError
  void set_touch(const TouchRule& rule);
  /// From the next step on. @throws InputError
  void set_gravity(const Vec3& gravity);

  /// Tells a watcher of all steps from the next one on, and keeps it.
  void watch(std::unique_ptr<Watcher> watcher);
  std::span<const std::unique_ptr<Watcher>> watchers() const;

  const WorldOptions& options() const;
  const State& state() const;
  /// Replaces the state (resume); sizes must match. @throws InputError
  void set_state(State state);

  /// Advances by options().time_step. Never throws for numerical trouble: the report says it.
  StepReport step();
  /// True while a body sleeps. Only where options().sleep is set.
  bool asleep(int b) const;
  /// Wakes a body and what sleeps with it: before something acts on it that the world does not see.
  void wake(int b);
  /// Contact nodes of the last sub-step, in a fixed order.
  std::span<const ContactSample> contacts() const;
  /// Tiles that were rasterized for two parts or more in the last sub-step: key and step h.
  std::span<const std::pair<TileKey, double>> active_tiles() const;
  /// Contact stiffness given, or the largest that the loads ask for between parts that do not deform, [Pa].
  double stiffness() const;
  /// [m] grid step at which a part is sampled by itself.
  double voxel_size(int part) const;
  /// Density of one part on arbitrary tiles of step h, for viewers and tests.
  void density(int part, double h, std::span<const TileKey> tiles, std::span<DensityBlock> out) const;
  /// Hash of the whole state: equal runs have equal hashes at every step.
  std::uint64_t hash() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace brim
