#pragma once

#include <memory>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/applied_force.h"
#include "brim/world/matter_points.h"
#include "brim/world/world_part.h"

namespace brim {

/// What acts on bodies from outside (AppliedForce), as generalised impulses of a sub-step. For bodies of every kind:
///   force F, torque T on the whole   Q = M v,  v the rigid motion of acceleration F/m, or α with vᵀ M v α = T
///   at points                        Q = Jᵀ f, J the body's map there
///   gravity scale                    the body's own weight in an environment of its own
/// Same bits for any number of threads.  Tests: tests/world/outer_actions_test.cpp
class OuterActions {
 public:
  /// @param ramp_voxels  w over h  @throws InputError  @return number of the entry
  int add(const AppliedForce& force, std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
          std::span<const double> q, std::span<const std::size_t> first_q, double ramp_voxels);
  bool empty() const { return entries_.empty(); }
  /// Of each body; shape (bodies at the last add), empty where nothing scales it.
  std::span<const double> gravity_scale() const { return gravity_scale_; }
  Environment environment(std::size_t body, const Environment& env) const {
    return body < gravity_scale_.size() ? Environment{gravity_scale_[body] * env.gravity} : env;
  }
  /// [N s] over a sub-step, added to `base`; shape (nv). Bodies are at their last update.
  /// @param base  shape (nv) or empty
  std::span<const double> impulse(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
                                  std::span<const double> q, std::span<const std::size_t> first_q,
                                  std::span<const double> v, std::span<const std::size_t> first_v,
                                  const Environment& env, double time, double dt, std::span<const double> base);

 private:
  /// An entry on one body.
  struct Action {
    int body = 0, part = 0;  ///< part: in the world's numbers
    MatterPoints points;     ///< where the force acts, or the middles of the display's triangles
    std::vector<Vec3> now;
  };
  struct Entry {
    AppliedForce given;
    std::vector<Action> actions;
  };
  /// @param scale  of the air's velocity, at the time
  void add_wind(const AppliedForce& given, double scale, Action& action, const WorldPart& part,
                std::span<const double> v, double time, double dt, std::span<double> Q) const;

  std::vector<Entry> entries_;
  std::vector<double> gravity_scale_, impulse_;
};

}  // namespace brim
