#pragma once

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "brim/body/aimed_drives.h"
#include "brim/body/body.h"
#include "brim/world/step_report.h"
#include "brim/world/touch_rules.h"

namespace brim {

struct AppliedForce;  // brim/world/applied_force.h
struct Attachment;    // brim/world/attachment.h
struct Pose;          // brim/raster/shape.h
struct QueryHit;      // brim/world/queries.h
class Watcher;        // brim/world/watcher.h
struct Wiring;        // brim/world/wiring.h

/// Parameters of a pair of materials that override those derived from the two.
struct PairMaterial {
  double friction = -1.0;                 ///< [-] Coulomb coefficient; negative: geometric mean of the two
  double stiffness = 0.0;                 ///< [Pa] k; 0: chosen from the loads and the softer of the two
  double restitution = -1.0;              ///< [-] e of the constraint response; negative: the larger of the two
  Response response = Response::Inherit;  ///< Inherit: as the bodies say, then the world
  double rolling_resistance = -1.0;       ///< [m] of rigid bodies; negative: the larger of the two
};

/// Options of stepping. docs/numerics.md gives the reasons.
struct WorldOptions {
  Environment environment;
  double time_step = 1.0 / 60.0;   ///< [s] of one call of step()
  double voxel_size = 0.0;         ///< [m] h0, the finest step; 0: the finest that a part requests
  double ramp_voxels = 3.0;        ///< ramp width over h, 2 to 4
  double stiffness = 0.0;          ///< [Pa] k; 0: chosen pair by pair, from the loads and the softer of the two
  double damping_steps = 2.0;      ///< β over dt, stiffness-proportional damping of contact
  double max_motion_voxels = 1.0;  ///< relative motion allowed in one sub-step, (0, 2]
  int max_substeps = 64;
  int min_substeps = 1;
  double cg_tolerance = 1e-4;  ///< relative residual
  int cg_max_iterations = 2000;
  int max_passes = 4;  ///< maximum number of solves per sub-step, while contacts are released or friction changes
  double friction_speed =
      0.0;  ///< [m/s] ε of the regularised friction; 0: 0.001 g dt, g of the earth where there is none
  /// For pairs whose materials and bodies set none; Inherit, the default of scenes: constraint rows between two solids
  /// if no stiffness is given, else penalties (default_response).
  Response response = Response::Penalty;
  double constraint_tolerance = 1e-4;  ///< change of velocity by the last sweep, over that of a free fall in a step
  /// Maximum number of projected Gauss-Seidel sweeps of a solve; five times as many where it would end with a warning.
  int constraint_sweeps = 200;
  bool constraint_every_node = false;  ///< one row per node instead of a few per patch: expensive, for comparison
  bool sleep = false;                  ///< leaves resting islands of bodies out of the step until touched (Sleep)
  double memory_limit = 8e9;           ///< [bytes] of samples, contacts, rows and pairs, each; above it InputError
  std::map<std::pair<std::string, std::string>, PairMaterial> pair_materials;  ///< by material names, sorted
  std::vector<TouchRule> touch_rules;  ///< which bodies touch; the last rule about a pair decides
};

/// The mutable state of a world: flat arrays in body order.
struct State {
  double time = 0.0;      ///< [s]
  std::int64_t step = 0;  ///< number of steps taken
  std::vector<double> q;  ///< generalised coordinates, shape (nq)
  std::vector<double> v;  ///< generalised velocities, shape (nv)
  /// Further state for the next step: impulses of constraint rows, references of solids, sleeping bodies, broken links,
  /// edits, levels of detail, and the states of watchers.
  std::vector<double> warm_start;
  /// Attachments and forces that exist; null in recordings and states made by hand: the world keeps those that it has.
  std::shared_ptr<const Wiring> wiring;
};

/// A global part: part `index` of body `body`.
struct PartRef {
  int body = 0, index = 0;
};

/// Which bodies a query sees, by their numbers; none: all.
using BodyFilter = std::function<bool(int body)>;

/// Bodies, their state, and the step that moves them (design: one step). Every number of a body, part, attachment or
/// force that is not there throws InputError.
class World {
 public:
  explicit World(WorldOptions options = {});
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// Adds a body; its name must be unique. @return its number
  /// @throws InputError, and exceptions of the body; the world is then unchanged
  int add(std::unique_ptr<Body> body);
  int body_count() const;
  const Body& body(int b) const;
  int part_count() const;
  PartRef part(int p) const;
  /// Slices of the state that belong to body b.
  std::span<const double> q(int b) const;
  std::span<const double> v(int b) const;

  /// Attaches a body to another one or to space, at their present positions (docs/links.md). May be called between
  /// steps; a resumed run must have the same attachments in the same order. Setting a state from before takes it away,
  /// and one from after brings it back. @return its number, its place among those that exist  @throws InputError
  int attach(const Attachment& attachment);
  int attachment_count() const;
  const Attachment& attachment(int i) const;
  /// Number that no other attachment of this world ever has, whatever states are set.
  std::int64_t attachment_id(int i) const;
  /// True once it broke or was detached; part of the state.
  bool detached(int i) const;
  void detach(int i);
  /// Target of a joint's drive from the next step on, [rad, m] and [rad/s, m/s], in place of its keyframes. Part of the
  /// state.
  /// @throws InputError when it has no drive
  void set_drive(int i, double position, double velocity);
  /// Names of the joints of a body that have a drive; empty for bodies without (AimedDrives). A drive's number is its
  /// place here.
  std::span<const std::string> drives(int b) const;
  /// Target of the drive of a body's joint from the next step on, [rad, m] and [rad/s, m/s], which holds until set
  /// again; keyframes of the drive end. Of the two, the drive follows those for which it has a stiffness or a damping.
  /// Part of the state. Wakes the body. @throws InputError
  void set_drive(int b, std::string_view joint, double position, double velocity);
  void set_drive(int b, int drive, double position, double velocity);
  /// The same for all drives of a body. @param velocity  empty: 0  @throws InputError  when lengths differ
  void set_drives(int b, std::span<const double> position, std::span<const double> velocity = {});
  /// Target that was set of an attachment's drive, and of a drive of a body; nothing: as described.
  std::optional<DriveAim> aim(int i) const;
  std::optional<DriveAim> aim(int b, int drive) const;
  /// Adds an external action on bodies, at their present positions. Setting a state from before takes it away.
  /// @throws InputError  @return its number, its place among those that exist
  int apply(const AppliedForce& force);
  /// Ends an external action. Those behind it move up by one place. Setting a state from before brings it back.
  /// @throws InputError
  void remove_force(int i);
  int force_count() const;
  /// Number that no other external action of this world ever has.
  std::int64_t force_id(int i) const;
  /// Changes a body's velocities at once by an impulse [N s] at its matter that is at a point [m] now, as attachments
  /// find it: solids take any point. The momentum changes by the impulse, and the angular momentum by its moment, where
  /// nothing of the body is fixed; attachments and contacts answer in the next step. Wakes the body.
  /// @throws InputError  @return where it acted [m]
  Vec3 apply_impulse(int b, const Vec3& impulse, const Vec3& point);

  /// Grabs a body by a spring to a point in space, at the material that is there now (a deformable body: all material
  /// within two voxels). Releases the previous grab. Not part of the state, reports or records: the hand is not in the
  /// world. @param at  [m]  @param stiffness  [N/m]; 0: 3 Hz with the body's mass
  /// @param damping  [N s/m]; 0: half of critical damping with that mass  @throws InputError
  void grab(int b, const Vec3& at, double stiffness = 0.0, double damping = 0.0);
  /// Moves the target of the grabbed point from the next step on, [m]. @throws InputError
  void pull(const Vec3& to);
  void release();
  /// The grabbed body, or −1.
  int grabbed() const;

  // ---- editing, between steps (docs/editing.md): part of the state, so that a run that was edited resumes right -----
  /// Removes a body. Its number and name stay reserved and those of others stay as they are; its q and v keep their
  /// last values. Its attachments are detached; forces on it end. @throws InputError
  void remove(int b);
  bool removed(int b) const;
  /// Fixes a body in place, like an obstacle, or releases it again, at rest.
  /// @throws InputError  for a body moved by keyframes
  void freeze(int b, bool frozen = true);
  bool frozen(int b) const;
  /// Moves all of a body from x to R x + t, and rotates its velocities by R.
  /// @throws InputError  for kinds that cannot be moved, attached bodies, and bodies moved by keyframes
  void move(int b, const Pose& by);
  /// Gives a body a rigid velocity: of its centre of mass [m/s], and about it [rad/s]. An obstacle keeps it until it is
  /// given another, in place of its keyframes; its velocity is that of the origin of its frame. @throws InputError
  void set_velocity(int b, const Vec3& velocity, const Vec3& angular_velocity);
  /// Moves an obstacle to a pose of its frame at constant velocities, by the shorter turn, and holds it there. Contact
  /// sees these velocities, so that it pushes and carries. Replaces its keyframes. Part of the state.
  /// @param duration  [s] 0: one step  @throws InputError  for bodies other than obstacles
  void set_target(int b, const Pose& pose, double duration = 0.0);
  /// Sets the surface material of all parts of a body from now on. @throws InputError
  void set_material(int b, const Material& material);
  /// Present material of one part.
  Material material(int b, int part = 0) const;
  /// Replaces the parameters of a pair of materials, by their names. @throws InputError
  void set_pair_material(const std::string& a, const std::string& b, const PairMaterial& pair);
  /// [Pa] contact stiffness of all pairs without a stiffness of their own. @throws InputError
  void set_stiffness(double stiffness);
  /// Calls the edit at the start of the first step that begins at `at` [s] or later. Not part of the state: a state
  /// from after that time contains the edit. An exception of the edit becomes the warning "edit_refused".
  void schedule(double at, std::function<void(World&)> edit);
  /// Sets whether bodies touch, from the next step on; overrides earlier rules, and replaces those of the same two
  /// names. Names that no body has yet are allowed: the rule is about those that are added later.
  /// @throws InputError  when there are more than 64 rules of different names
  void set_touch(const TouchRule& rule);
  /// Sets gravity from the next step on. @throws InputError
  void set_gravity(const Vec3& gravity);

  /// Registers a watcher of all steps from the next one on, and owns it. @throws InputError  for none
  void watch(std::unique_ptr<Watcher> watcher);
  std::span<const std::unique_ptr<Watcher>> watchers() const;

  const WorldOptions& options() const;
  /// The present state. Ask again after each step and edit.
  const State& state() const;
  /// Replaces the state (resume); sizes must match, and of a state of another world all attachments and forces must be
  /// here by name. @throws InputError
  void set_state(State state);

  /// Advances by options().time_step. Never throws for numerical failure: the report shows it.
  StepReport step();
  /// What the first step will warn of in the materials.
  std::vector<Warning> material_warnings();
  /// The report of no step: energies and speed of the present state, without contact.
  StepReport present();
  /// True while a body sleeps. Only if options().sleep is set.
  bool asleep(int b) const;
  /// Wakes a body and its island: to be called before an action on it that the world does not see.
  void wake(int b);
  /// Contact nodes of the last sub-step, in a fixed order.
  std::span<const ContactSample> contacts() const;
  /// Tiles that were rasterized for two parts or more in the last sub-step: key and step h.
  std::span<const std::pair<TileKey, double>> active_tiles() const;
  /// Contact stiffness given, or the largest required by the loads between parts that do not deform, [Pa].
  double stiffness() const;
  /// [m] grid step at which a part is sampled by itself.
  double voxel_size(int part) const;
  /// Density of one part on arbitrary tiles of step h, for viewers and tests.
  void density(int part, double h, std::span<const TileKey> tiles, std::span<DensityBlock> out) const;

  // ---- queries of the present state: nothing is kept between them (docs/cpp.md#queries) ----
  /// First surface that a ray meets, within max_distance [m]; bodies in which it begins are met at distance 0. Of equal
  /// distances that of the first body. @param direction  of any length but 0  @throws InputError
  std::optional<QueryHit> raycast(const Vec3& origin, const Vec3& direction,
                                  double max_distance = std::numeric_limits<double>::infinity(),
                                  const BodyFilter& filter = {}) const;
  /// Nearest point of any surface within max_distance [m]; within bodies, of the one in which the point lies deepest.
  /// @throws InputError
  std::optional<QueryHit> closest_point(const Vec3& point,
                                        double max_distance = std::numeric_limits<double>::infinity(),
                                        const BodyFilter& filter = {}) const;
  /// Numbers of the bodies with matter in a ball, ascending. @param radius  [m] 0: at a point  @throws InputError
  std::vector<int> overlap_ball(const Vec3& center, double radius, const BodyFilter& filter = {}) const;
  /// The same in a box. @param box  pose of its centre  @param extents  [m] full  @throws InputError
  std::vector<int> overlap_box(const Pose& box, const Vec3& extents, const BodyFilter& filter = {}) const;

  /// Hash of the whole state: equal runs have equal hashes at every step.
  std::uint64_t hash() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace brim
