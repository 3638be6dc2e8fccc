#pragma once

#include <span>
#include <vector>

#include "brim/body/meets_itself.h"
#include "brim/world/contact_stage.h"
#include "brim/world/world_part.h"

namespace brim {

/// Self-contact of bodies (MeetsItself): their pieces are searched as the parts of a world are, and the results are
/// contacts of part 0 of the body with itself, by its own maps and always by penalties. Nothing is kept from step to
/// step. Same bits for any number of threads.  Tests: tests/world/self_contact_test.cpp
class SelfContact {
 public:
  /// Appends the contacts of a sub-step: for each two pieces a pair with part_a = part_b.
  void find(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
            double dt, const WorldOptions& options, StepReport& report, ContactSet& contacts);
  /// Sub-steps required by the motion of pieces, as motion_pieces computes it for parts.
  double motion_pieces(std::span<const WorldPart> parts, std::span<const double> v,
                       std::span<const std::size_t> first_v, const WorldOptions& options, double time, double change,
                       BoxSweep& sweep);

 private:
  /// Calls f(part number, body as MeetsItself) for bodies with self-contact, with their pieces in piece_.
  template <class F>
  void for_bodies(std::span<const WorldPart> parts, const F& f);
  /// Takes contacts that are not between neighbours along the body.
  void take(const MeetsItself& body, std::int32_t part, ContactSet& contacts) const;

  std::vector<WorldPart> piece_;  ///< of one body
  ContactStage stage_;
};

}  // namespace brim
