#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "brim/body/outer_forces.h"
#include "brim/scene/document.h"
#include "brim/scene/given_arrays.h"
#include "brim/scene/scene.h"
#include "brim/scene/solid_store.h"
#include "brim/world/levels.h"
#include "brim/world/world.h"
#include "caller_thread.h"

namespace brim::python {

namespace py = pybind11;

/// A world as seen by Python: its scene, entry by entry, the world itself, and Python's view of its state.
///
/// Python's view of the state lies in arrays of its own, one pair per body, whose memory never moves: written after
/// each step, and read before the next, so that Python may write to them. So arrays outlive additions and restorations,
/// and other threads always see the last complete state.
class Session {
 public:
  /// An empty world. @param scene  a scene without its bodies  @param folder  base of relative paths
  Session(const py::dict& scene, std::string folder);
  /// The world of a scene file. @param set, seed  as --set and --seed of the program @throws InputError
  static std::unique_ptr<Session> load(const std::string& path, const py::dict& set, std::optional<std::uint64_t> seed);

  /// Adds an entry of "bodies" through the scene reader. Nothing is added on error.
  /// @return numbers of the new bodies  @throws InputError
  std::vector<int> add(const py::dict& entry);
  /// Adds a body whose author is a Python object. @param entry  as for a rigid body: its shape is the surface
  int add_own(const py::dict& entry, const py::object& author, const py::object& q, const py::object& v,
              double mass_spacing, double stiffness_damping);
  /// check_own_body of a body. @throws InputError  when it is no own body
  std::vector<std::string> check_own(int body, unsigned seed);

  /// Adds an entry of "attachments", "joints", "forces", "filters" or "sensors" through the scene reader; nothing on
  /// error.
  /// @return its number in the world, -1 for a filter  @throws InputError
  /// @param field  of a force's wind: (t, x) -> velocities, both of shape (n, 3), or None
  int wire(const std::string& list, const py::dict& entry, const py::object& field);
  void detach(int attachment);
  /// Ends the force of a name. @throws InputError  when there is none
  void remove_force(const std::string& name);
  void set_drive(int attachment, double position, double velocity);
  /// Targets of the drives of an articulated body: [first, first + n) of them, shape (n,). @param velocity  may be
  /// empty
  void aim_drives(int body, int first, std::span<const double> position, std::span<const double> velocity);
  void grab(int body, const std::array<double, 3>& at, double stiffness, double damping);
  void pull(const std::array<double, 3>& to);
  void release();
  void set_gravity(const std::array<double, 3>& gravity);
  // Edits of bodies, by number (World has the same).
  void remove(int body);
  void freeze(int body, bool frozen);
  /// x → R x + t. @param rotation  R row by row
  void move(int body, const std::array<double, 9>& rotation, const std::array<double, 3>& translation);
  void set_velocity(int body, const std::array<double, 3>& velocity, const std::array<double, 3>& angular_velocity);
  /// @return where it acted [m]
  std::array<double, 3> apply_impulse(int body, const std::array<double, 3>& impulse,
                                      const std::array<double, 3>& point);
  /// @param position, rotation  none: as they are  @param rotation  row by row
  void set_target(int body, const std::optional<std::array<double, 3>>& position,
                  const std::optional<std::array<double, 9>>& rotation, double duration);
  /// @param material  "name", "friction", "restitution", "rolling_resistance", "response", as material() gives them
  void set_material(int body, const py::dict& material);
  py::dict material(int body);
  /// A material of the scene by its name. @throws InputError
  py::dict named_material(const std::string& name);
  /// @param pair  "friction", "stiffness", "restitution", "rolling_resistance", "response", each absent or a value
  void set_pair_material(const std::string& a, const std::string& b, const py::dict& pair);
  void set_stiffness(double stiffness);

  /// One step. @param joined  the report accumulates this step with those before it
  /// @param forces  generalised forces on bodies over this step, by number: arrays of shape (nv)
  /// @throws the exceptions of Python code below it; the state is then that before the step
  void step(bool joined, const std::map<int, py::object>& forces);
  /// True when forces can act on a body.
  bool takes_forces(int body) const { return outer_.at(static_cast<std::size_t>(body)) != nullptr; }

  State state();
  void set_state(State state);
  /// Python's view of a body: memory that stays in place as long as this object.
  std::span<double> seen_q(int body) { return mirror(body).q; }
  std::span<double> seen_v(int body) { return mirror(body).v; }
  /// True when the body was removed before the last complete state.
  bool seen_removed(int body) { return mirror(body).removed; }

  /// The world, updated with Python's changes; not during a step. @throws py::error_already_set (RuntimeError)
  World& world();
  const StepReport& report() const { return report_; }
  /// The scene without its bodies: the attachments, joints and forces that exist now, and targets of drives that were
  /// set as edits of the timeline at 0.
  Json head();
  const Json& entries() const { return entries_; }
  const std::string& folder() const { return folder_; }
  /// Runs f with the interpreter's lock released, serving calls of Python bodies.
  void unlocked(const std::function<void()>& f);

  /// For a loaded scene: its file and text; empty otherwise, or once a body was added.
  std::string file, text;
  std::vector<Expectation> expect;
  std::int64_t frames = 0;
  int steps_per_frame = 1;
  std::shared_ptr<GivenArrays> arrays = std::make_shared<GivenArrays>();

 private:
  struct Mirror {
    std::vector<double> q, v;
    bool removed = false;  ///< when the body was looked at last
  };
  struct Busy;
  struct Acting;
  Session() = default;
  std::map<std::string, Material> materials() const;
  Scene checked(const Json& entry, const std::string& kind = {}) const;
  /// "levels" of the world; they may name bodies that are still to come. @throws InputError
  std::optional<LevelOptions> levels() const;
  Mirror& mirror(int body);
  /// @throws InputError  when there is none of this number
  void check_attachment(int attachment) const;
  void read_mirrors();
  void fill_mirrors();
  void take(std::unique_ptr<Body> body);
  /// Applies Python's changes, edits the world, and updates Python's view.
  void edit(const std::function<void()>& change);
  void include(std::vector<std::unique_ptr<Body>> bodies, const Json& entry);

  Json head_, entries_ = Json::array();
  /// Numbers of the entries of "attachments", "joints" and "forces" in head_ (World::attachment_id, force_id).
  std::map<std::string, std::vector<std::int64_t>> wired_;
  std::string folder_;
  std::set<std::string> names_;
  std::unique_ptr<World> world_;
  SolidStore solids_;                             // solids of bodies that were added one by one
  std::vector<std::unique_ptr<Mirror>> mirrors_;  // shape (bodies); null where Python has not looked
  std::vector<OuterForces*> outer_;               // shape (bodies); null for kinds without such forces
  std::shared_ptr<CallerThread> caller_ = std::make_shared<CallerThread>();
  bool served_ = false;  // some body is written in Python
  StepReport report_;
  bool busy_ = false;  // guarded by the interpreter's lock
};

}  // namespace brim::python
