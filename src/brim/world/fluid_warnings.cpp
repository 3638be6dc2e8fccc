#include "brim/world/fluid_warnings.h"

#include <fmt/format.h>

#include "brim/body/flows_around.h"
#include "brim/core/interface_of.h"

namespace brim {

namespace {
/// [m/s] sound in water.
constexpr double kSound = 1500.0;

const FlowsAround* moving_fluid(const WorldPart& p) {
  return is_fixed(p) ? nullptr : interface_of<FlowsAround>(*p.body);
}
}  // namespace

std::optional<std::string> runaway_fluid(std::span<const WorldPart> parts, std::span<const double> v,
                                         std::span<const std::size_t> first_v) {
  for (const WorldPart& p : parts) {
    if (moving_fluid(p) == nullptr) continue;
    const double speed = speed_bound(p, velocities_of(p, v, first_v));
    if (speed > kSound)
      return fmt::format(
          "'{}' runs at {:.2g} m/s, faster than sound in water: the solids around it leave it no way out, or its cells "
          "are too coarse for the gaps between them; the state before is kept",
          p.body->name(), speed);
  }
  return {};
}

std::optional<std::string> meeting_fluids(std::span<const WorldPart> parts) {
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t j = i + 1; j < parts.size(); ++j) {
      const FlowsAround *a = moving_fluid(parts[i]), *b = moving_fluid(parts[j]);
      if (a == nullptr || b == nullptr || !rules_allow(parts[i], parts[j])) continue;
      const Aabb shared = a->flow_grid().box().intersection(b->flow_grid().box());
      if ((shared.extent().array() <= 0.0).any()) continue;
      return fmt::format("'{}' and '{}' are both fluids on grids: where they meet they gain energy, even at rest",
                         parts[i].body->name(), parts[j].body->name());
    }
  return {};
}

}  // namespace brim
