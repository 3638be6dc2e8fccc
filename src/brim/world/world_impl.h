#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

#include "brim/math/box_sweep.h"
#include "brim/response/penalty.h"
#include "brim/world/constraint_step.h"
#include "brim/world/contact_maps.h"
#include "brim/world/contact_parameters.h"
#include "brim/world/contact_stage.h"
#include "brim/world/drive_aims.h"
#include "brim/world/edits.h"
#include "brim/world/fill_stage.h"
#include "brim/world/fluid_coupling.h"
#include "brim/world/free_flight.h"
#include "brim/world/implicit_step.h"
#include "brim/world/kinematic_motions.h"
#include "brim/world/levels.h"
#include "brim/world/links.h"
#include "brim/world/outer_actions.h"
#include "brim/world/part_filter.h"
#include "brim/world/self_contact.h"
#include "brim/world/sleep.h"
#include "brim/world/touch_rules.h"
#include "brim/world/turning.h"
#include "brim/world/watcher.h"
#include "brim/world/wiring.h"
#include "brim/world/world.h"
#include "brim/world/world_part.h"

namespace brim {

struct SeenMatter;

/// Data of a world. Its functions are sorted by topic: world.cpp bodies and state, world_wiring.cpp how they are
/// connected, world_editing.cpp changes between steps, world_absences.cpp bodies that are out and what edits change,
/// world_step.cpp a step, world_substep.cpp and world_advance.cpp a sub-step, world_touched.cpp what contact tells
/// bodies.
struct World::Impl {
  WorldOptions options;  ///< as edited
  WorldOptions given;    ///< as constructed
  std::vector<std::unique_ptr<Body>> bodies;
  std::unordered_set<std::string> names;
  std::vector<WorldPart> parts;
  std::vector<double> part_h;  ///< [m] grid steps of the parts, chosen at the start
  std::vector<std::size_t> first_q{0}, first_v{0};
  State state;
  bool started = false;
  bool edited = false;  ///< edits wait for the next start()
  ContactParameters laws;
  Sleep sleep;
  TouchRules rules;
  PartFilter filter;  ///< rules with regions: those of the options first, then those of set_touch
  Links links;
  std::shared_ptr<Vec3> grab_goal;  ///< [m] target of the grabbed point
  OuterActions actions;
  bool has_space = false;  ///< the last body and part stand for space
  Levels levels;
  Edits edits;
  DriveAims aims;
  KinematicMotions motions;
  /// A body that was removed, or brought back: the object in its place, and its own coordinates meanwhile.
  struct Absence {
    std::unique_ptr<Body> other;
    std::vector<double> q, v;
    bool out = false;
  };
  std::vector<Absence> absences;  ///< by body; empty as long as none was removed
  State whole;                    ///< including removed bodies, if there are any; found when it is asked for
  bool whole_is_old = true;
  struct Scheduled {
    double at = 0.0;
    std::function<void(World&)> edit;
  };
  std::vector<Scheduled> scheduled;
  std::vector<std::unique_ptr<Watcher>> watchers;
  std::uint64_t own_number = 0;  ///< of this world, for Wiring
  const World* self = nullptr;   ///< the world shown to watchers

  ContactStage stage;
  SelfContact self_contact;
  FillStage fill;
  FluidCoupling coupling;
  bool fluids_told = false;  ///< whether two fluids may meet has been said
  BoxSweep motion_sweep;     ///< for the choice of sub-steps
  HeldPairs held_pairs;      ///< that rows connected in the last sub-step
  FreeFlight flight;
  ContactMaps maps;
  Turning turning;
  Penalty response;
  ImplicitStep implicit;
  ConstraintStep constraints;
  std::vector<Vec3> velocity_a, velocity_b;
  std::vector<Vec3> normal_force, friction_force, contact_force;  ///< [N] at the contacts; contact_force: their sum
  std::vector<double> delta, before_q, before_v;
  std::vector<double> gravity_factor;  ///< per body, where links hold any
  std::vector<double> predicted_v;     ///< velocities that a solve found
  std::vector<double> way_v;           ///< way of the sub-step over dt: with the correction of overlaps
  // State of the last update of the bodies, from which they have not been advanced since.
  std::vector<double> updated_q, updated_v;
  double updated_time = 0.0;
  std::vector<std::uint8_t> fresh;
  std::vector<ContactSample> samples;

  std::span<double> q(std::size_t b) { return std::span(state.q).subspan(first_q[b], first_q[b + 1] - first_q[b]); }
  std::span<double> v(std::size_t b) { return std::span(state.v).subspan(first_v[b], first_v[b + 1] - first_v[b]); }

  /// Makes the choices of the first step, and applies what was edited since the last call. Many edits in a row cost
  /// little more than one.
  void start();
  /// The grid steps of the parts, and the stiffness of contact that the loads want.
  void choose_steps();
  /// Applies what was edited since the last start.
  void catch_up() {
    if (edited) start();
  }
  /// [Pa] given, or chosen from the loads.
  double stiffness() const { return options.stiffness > 0.0 ? options.stiffness : laws.stiffness(); }
  /// Appends a complete body: its exceptions have been thrown before.
  void append(std::unique_ptr<Body> body, std::span<const double> q0, std::span<const double> v0);
  void show_space();
  void hide_space();
  std::size_t count() const { return bodies.size() - has_space; }  ///< number of bodies visible to others
  int find(const std::string& name) const;
  Links::Side side_of(int body);
  /// take_memory reads the state of links, sleep and others from memory; keep_memory writes it back in front.
  void take_memory();
  void keep_memory();
  /// Numbers that a user gave, as indices. @throws InputError
  std::size_t body_index(int b, const char* what) const;
  std::size_t part_index(int p, const char* what) const;
  std::size_t link_index(int i, const char* what) const;
  [[noreturn]] void refuse_name(const std::string& name) const;
  /// The body that was added, even if another object stands in its place now.
  const Body& own(std::size_t b) const;
  /// The same by a number that may be none, for DriveAims and KinematicMotions.
  Body* aimed(int b);
  bool out(std::size_t b) const { return b < absences.size() && absences[b].out; }
  /// Coordinates and velocities of a body, removed or not.
  std::span<const double> kept_q(std::size_t b) const;
  std::span<const double> kept_v(std::size_t b) const;
  /// True from the call of remove on; out() from the start() that follows.
  bool is_removed(std::size_t b) const { return !edits.removed.empty() && edits.removed.contains(static_cast<int>(b)); }
  bool is_frozen(std::size_t b) const { return !edits.frozen.empty() && edits.frozen.contains(static_cast<int>(b)); }
  /// @throws InputError  when the number is not that of a body, or the body was removed
  void need(int b, const char* what) const;
  /// Changes the edits; start() changes everything derived from them.
  void edit(const std::function<void(Edits&)>& change);
  /// Brings all removed bodies back temporarily, so that the state contains all; leave_out takes them out again.
  void bring_back();
  void leave_out();
  bool bases_moved = false;  ///< some base may differ from the start
  void set_bases();
  /// Applies the edits to options, rules and parts.
  void follow_edits();
  /// The state with that of removed bodies, for others to see.
  const State& whole_state();
  void gather_whole(std::vector<double>& all_q, std::vector<double>& all_v) const;
  void count_state();
  PartInfo info_of(const WorldPart& p) const;
  /// Wakes bodies affected by a change of a body: its island; all bodies, if it is fixed.
  void wake_around(int b);
  void wake(std::size_t b);
  void wake_all();
  void run_scheduled(World& world, StepReport& report);
  /// World::set_drives of some drives of a body. @throws InputError  for what is not finite
  void aim(int b, std::size_t first, std::span<const double> position, std::span<const double> velocity);
  /// Gives an obstacle a motion from now on.
  void drive(int b, const KinematicMotion& motion);
  void keep_apart();
  /// Writes down in the state which attachments and forces exist.
  void note_wiring();
  /// The wiring of a state in the objects of this world. @throws InputError  for names that this world does not have
  std::shared_ptr<const Wiring> wiring_of(const State& other) const;
  void update_bodies();
  /// Marks sleeping bodies as unchanged; all others must be updated.
  void stir();
  /// True when a body at rest changes by itself within the coming time (TimeDriven), [s].
  bool driven(std::size_t b, double dt);
  void prescribe(double dt);
  /// Chooses the levels of a step and smooths the change of contact.
  void choose_levels(StepReport& report);
  void find_contacts(double dt, StepReport& report);
  /// Wakes bodies in contact with an awake one. @return true when there were any
  bool wake_touched();
  /// Wakes bodies in fluids, which push them at any time.
  void wake_in_fluids();
  /// Tells bodies whose surface yields to contact where they are touched.
  void tell_touched();
  /// Tells bodies of balls the loads that fixed contacts will put on them.
  void tell_loads(double dt);
  /// Tells bodies with walls of their own the forces on them in a sub-step. @param mapped  [N] (n_v) contact forces on
  /// the coordinates of all bodies; empty: computed here if needed
  void tell_walled(double dt, std::span<const double> mapped);
  /// Number of sub-steps required by motion at these velocities in a time, [s]. @param change  [m/s] largest change of
  /// any
  double motion_pieces(std::span<const double> velocities, double time, double change);
  /// One sub-step of at most `left` [s]. @return its length
  double substep(double left, StepReport& report);
  double choose_length(double left, StepReport& report);
  /// Solves a sub-step, in pieces if it moves parts too far. @return its length; report.ok is false if not finite
  double solve_within_limits(double dt, StepReport& report);
  bool solve_substep(double dt, StepReport& report);
  /// Prescribed velocities, the bodies' update, contacts and links.
  void begin_substep(double dt, StepReport& report);
  void begin_penalties(double dt, StepReport& report);
  void begin_rows(double dt, StepReport& report);
  bool solve_system(double dt, StepReport& report);
  /// motion_pieces of the velocities that the solve found, with what it throws.
  double pieces_after_solve(double dt, StepReport& report);
  /// Tells links the forces that the solve found.
  void find_swing(StepReport& report);
  /// The forces of all contacts and links that the solve found.
  void find_contact_forces();
  /// The first body whose numbers are not finite after a solve that failed, for a message.
  std::string blame_for_nan() const;
  /// Back to the state before the sub-step.
  void take_back();
  /// Pairs, samples, links and momentum of a solved sub-step. @param last  of its step
  void report_substep(double dt, bool last, StepReport& report);
  void advance(double dt, StepReport& report);
  /// Brings the coupling of grid fluids to the state after the sub-step.
  void follow_solids(StepReport& report);
  /// The matter that a query sees, in the order of bodies, after edits and at the present state.
  std::vector<SeenMatter> seen(const BodyFilter& sees);
  void measure(StepReport& report);
  /// Energies of bodies and springs, and the largest speed. Bodies must be up to date.
  void measure_motion(StepReport& report);
};

}  // namespace brim
