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
/// (docs/numerics.md, Sticking to what turns): all of it for the rotation about the normal, its second order for the
/// rotation about other axes, of which what rolls makes none. Where a body rolls, the point of contact leaves the
/// material at the rate s, (C_a + C_b) s = (ω_a − ω_b) × n, and so comes to other velocities: ½ dt (ω_a − ω_b) × s
/// more.
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
  /// @param bend  [1/m] sum of the curvatures of both surfaces, any part along n
  Vec3 slip(const ContactPair& pair, const Vec3& x, const Vec3& n, const Vec3& u, const Mat3& bend) const;
  /// Adds it to the velocities of a at all contacts, links aside.
  void add_slips(const ContactSet& contacts, std::span<const Vec3> normals, std::span<Vec3> velocity_a,
                 std::span<const Vec3> velocity_b) const;

 private:
  std::span<const WorldPart> parts_;
  /// [m/s] Chord minus tangent of a part's material.
  Vec3 more(std::int32_t part, const Vec3& x, const Vec3& n) const;
  /// [m/s] What the rolling of the point of contact adds to it.
  Vec3 rolled(const ContactPair& pair, const Vec3& n, const Mat3& bend) const;

  std::vector<Turns::Turn> turn_;    ///< per part
  std::vector<std::uint8_t> asked_;  ///< per part, set at the first one of a body
  double dt_ = 0.0;
  bool any_ = false;
};

}  // namespace brim
