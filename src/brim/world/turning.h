#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "brim/body/turns.h"
#include "brim/contact/contact_set.h"
#include "brim/world/world_part.h"

namespace brim {

/// What sticks to a turning body must follow the chord of its arc: held to the tangent, a box on a turntable leaves it
/// by ω² r dt/2 a second. This adds the difference between chord and tangent to slips at the start of a step
/// (docs/numerics.md, Sticking to what turns).
class Turning {
 public:
  /// @param points  whose pairs are asked for
  /// @param v       velocities at the start of the step
  void begin(std::span<const WorldPart> parts, const ContactSet& points, std::span<const double> v,
             std::span<const std::size_t> first_v, double dt);
  /// False when no body turns.
  bool any() const { return any_; }
  /// [m/s] Chord minus tangent of a's material at x, less that of b's, across the normal; zero for points that slip.
  /// @param n  unit normal  @param u  [m/s] relative velocity a − b at x
  Vec3 slip(const ContactPair& pair, const Vec3& x, const Vec3& n, const Vec3& u) const;
  /// Adds it to the velocities of a at all contacts, links aside.
  void add_slips(const ContactSet& contacts, std::span<const Vec3> normals, std::span<Vec3> velocity_a,
                 std::span<const Vec3> velocity_b) const;

 private:
  std::span<const WorldPart> parts_;
  std::vector<Turns::Turn> turn_;  ///< per body
  std::vector<std::uint8_t> asked_;
  double dt_ = 0.0;
  bool any_ = false;
};

}  // namespace brim
