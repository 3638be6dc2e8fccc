#pragma once

#include <span>
#include <vector>

#include "brim/body/meets_itself.h"
#include "brim/world/contact_stage.h"
#include "brim/world/world_part.h"

namespace brim {

/// Contact of bodies with themselves (MeetsItself): their pieces are searched as the parts of a world are, and what is
/// found is contact of part 0 of the body with itself, by its own maps and always by penalties. Nothing is kept from
/// step to step. Same bits for any number of threads.  Tests: tests/world/self_contact_test.cpp
class SelfContact {
 public:
  /// Appends the contacts of a sub-step, a pair of parts that are the same for each two pieces.
  void find(std::span<const WorldPart> parts, std::span<const double> v, std::span<const std::size_t> first_v,
            double dt, const WorldOptions& options, StepReport& report, ContactSet& contacts);
  /// Sub-steps that the motion of pieces asks for, as motion_pieces says it of parts.
  double motion_pieces(std::span<const WorldPart> parts, std::span<const double> v,
                       std::span<const std::size_t> first_v, const WorldOptions& options, double time, double change,
                       BoxSweep& sweep);

 private:
  /// Calls f(number of a part, its body as that) for what touches itself, its pieces in piece_.
  template <class F>
  void for_bodies(std::span<const WorldPart> parts, const F& f);
  /// Takes what does not lie side by side along the body.
  void take(const MeetsItself& body, std::int32_t part, ContactSet& contacts) const;

  std::vector<WorldPart> piece_;  ///< of one body
  ContactStage stage_;
};

}  // namespace brim
