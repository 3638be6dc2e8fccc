#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "brim/body/body.h"
#include "brim/world/applied_force.h"
#include "brim/world/matter_points.h"
#include "brim/world/wind.h"
#include "brim/world/world_part.h"

namespace brim {

/// External actions on bodies (AppliedForce), as generalised impulses of a sub-step, for bodies of every kind:
///   force F, torque T on the whole   Q = M v,  v the rigid motion of acceleration F/m, or α with vᵀ M v α = T
///   at points                        Q = Jᵀ f, J the body's map there
///   in a region of a flow            Q = M v, v = F χ along each axis, χ = 1 in the region, 0 outside, scaled to F
///   gravity scale                    the body's weight computed in an environment of its own
/// Same bits for any number of threads.  Tests: tests/world/outer_actions_test.cpp
class OuterActions {
  struct Entry;

 public:
  /// Forces of a state, for Wiring.
  using List = std::vector<std::shared_ptr<Entry>>;

  /// @param ramp_voxels  w over h  @throws InputError  @return number of the entry
  int add(const AppliedForce& force, std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
          std::span<const double> q, std::span<const std::size_t> first_q, double ramp_voxels);
  bool empty() const { return entries_.empty(); }
  std::size_t size() const { return entries_.size(); }
  const AppliedForce& given(std::size_t i) const { return entries_[i]->given; }
  /// Number that no other entry of this world ever has.
  std::int64_t id(std::size_t i) const { return entries_[i]->id; }
  const List& list() const { return entries_; }
  void set_list(const List& list);
  /// Factor on gravity per body; shape (bodies at the last add or impulse), empty when none is scaled. The next of
  /// these invalidates it.
  std::span<const double> gravity_scale() const { return gravity_scale_; }
  /// Sets the flags of bodies with wind or a position-dependent force. @param flags  shape (bodies)
  void flag_pulled(std::span<std::uint8_t> flags) const;
  /// Sets the flags of bodies with any force that is not the same acceleration everywhere. @param flags  shape (bodies)
  void flag_acted_on(std::span<std::uint8_t> flags) const;
  /// Appends the bodies on which something acts that changes with time: by its scale around this sub-step, or by a wind
  /// field, of which nothing is known.
  void find_changing(double time, double dt, std::vector<int>& out) const;
  /// [N s] over a sub-step, added to `base`; shape (nv). Bodies are at their last update.
  /// @param base  shape (nv) or empty
  std::span<const double> impulse(std::span<const std::unique_ptr<Body>> bodies, std::span<const WorldPart> parts,
                                  std::span<const double> q, std::span<const std::size_t> first_q,
                                  std::span<const double> v, std::span<const std::size_t> first_v, double time,
                                  double dt, std::span<const double> base);
  /// [kg/s] by how much the air of the last impulse resists changes of velocity (WindOnBody): of the nodes of each
  /// body, empty for most; shape (bodies), or empty.
  std::span<const std::vector<Mat3>> resistance() const { return resistance_; }

 private:
  /// Points of one part on which a force acts.
  struct Spot {
    std::size_t part = 0;  ///< within the body
    MatterPoints points;
  };
  /// An entry on one body.
  struct Action {
    int body = 0;
    std::size_t first_part = 0;  ///< of the body, global number
    std::vector<Spot> spots;     ///< where the force acts, ...
    bool flow = false;           ///< ... or on the flow through the region
    std::optional<WindOnBody> wind;
    bool at_points() const { return flow || !spots.empty(); }
  };
  struct Entry {
    AppliedForce given;
    std::int64_t id = 0;
    std::vector<Action> actions;
  };
  /// Notes the factor of an entry on gravity. @param bodies  number of them
  void scale_gravity(const Entry& entry, std::size_t bodies);
  static void choose_points(const AppliedForce& given, std::span<const WorldPart> parts, std::span<const double> q,
                            double ramp_voxels, Action& action);
  static void add_in_flow(const AppliedForce& given, const Body& body, std::span<double> Q);
  /// @param parts  of the body  @param q, Q  of the body
  static void add_at_points(const Vec3& force, std::span<const WorldPart> parts, std::span<const double> q,
                            Action& action, std::span<double> Q);

  /// A body in a sub-step, and its impulse.
  struct Target;
  // What an entry adds to the impulse of a body. @param factor  scale over time, times dt, [s]
  static void add_damping(double damping, double dt, const Target& target);
  static void add_at_places(const AppliedForce& given, double factor, Action& action, const Target& target);
  static void add_wind(const AirStep& step, WindOnBody& wind, const Target& target, std::vector<Mat3>& resistance);
  /// On each node, for bodies with nodes.
  static void add_attraction(const AppliedForce::Attractor& attractor, double factor, const Target& target);
  /// Acceleration, torque, force without a place, and attraction of a body without nodes.
  static void add_as_whole(const AppliedForce& given, bool at_points, double factor, const Target& target);

  List entries_;  ///< shared with the states in which they exist
  std::int64_t next_id_ = 0;
  std::vector<double> gravity_scale_, impulse_;
  std::vector<std::vector<Mat3>> resistance_;
};

}  // namespace brim
