#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

#include "brim/response/penalty.h"
#include "brim/world/constraint_step.h"
#include "brim/world/contact_maps.h"
#include "brim/world/contact_stage.h"
#include "brim/world/fill_stage.h"
#include "brim/world/implicit_step.h"
#include "brim/world/levels.h"
#include "brim/world/links.h"
#include "brim/world/outer_actions.h"
#include "brim/world/pair_laws.h"
#include "brim/world/sleep.h"
#include "brim/world/touch_rules.h"
#include "brim/world/world.h"
#include "brim/world/world_part.h"

namespace brim {

/// What a world is made of. Its functions lie where their idea does: world.cpp holds bodies and state, world_wiring.cpp
/// what is said about them between steps, world_step.cpp a step, world_substep.cpp a sub-step.
struct World::Impl {
  WorldOptions options;
  std::vector<std::unique_ptr<Body>> bodies;
  std::unordered_set<std::string> names;
  std::vector<WorldPart> parts;
  std::vector<std::size_t> first_q{0}, first_v{0};
  State state;
  bool started = false;
  PairLaws laws;
  Sleep sleep;
  TouchRules rules;
  Links links;
  OuterActions actions;
  bool has_space = false;  ///< the last body and part stand for space
  Levels levels;

  ContactStage stage;
  FillStage fill;
  ContactMaps maps;
  Penalty response;
  ImplicitStep implicit;
  ConstraintStep constraints;
  std::vector<Vec3> velocity_a, velocity_b, normal_force, friction_force;
  std::vector<double> delta, before_q, before_v, travel;
  // The state that bodies were last updated to, and which have not been advanced since.
  std::vector<double> updated_q, updated_v;
  double updated_time = 0.0;
  std::vector<std::uint8_t> fresh;
  std::vector<ContactSample> samples;

  std::span<double> q(std::size_t b) { return std::span(state.q).subspan(first_q[b], first_q[b + 1] - first_q[b]); }
  std::span<double> v(std::size_t b) { return std::span(state.v).subspan(first_v[b], first_v[b + 1] - first_v[b]); }

  void start();
  /// Appends a body that is whole: what it throws has been thrown.
  void append(std::unique_ptr<Body> body, std::span<const double> q0, std::span<const double> v0);
  void show_space();
  void hide_space();
  std::size_t count() const { return bodies.size() - has_space; }  ///< of bodies that others see
  int find(const std::string& name) const;
  Links::Side side_of(int body);
  /// State of links and sleep comes out of memory, and goes back before all else in it.
  void take_memory();
  void keep_memory();
  void keep_apart();
  void update_bodies();
  /// Those that sleep are as they were; all others must be updated.
  void stir();
  void prescribe(double dt);
  /// Chooses the levels of a step, and eases over what changes with them.
  void choose_levels(StepReport& report);
  void find_contacts(double dt, StepReport& report);
  /// Wakes what something awake has contacts with. @return true where there was something
  bool wake_touched();
  double substep(double left, StepReport& report);
  bool solve_substep(double dt, StepReport& report);
  void measure(StepReport& report);
};

}  // namespace brim
