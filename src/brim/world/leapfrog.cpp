#include "brim/world/leapfrog.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "brim/body/rigid_frame.h"
#include "brim/core/interface_of.h"

namespace brim {

void leapfrog_gravity(std::span<const WorldPart> parts, const ContactStage& stage, std::size_t bodies, double before,
                      double dt, std::span<const double> given, std::vector<double>& factor) {
  factor.assign(bodies, 1.0);
  std::copy_n(given.begin(), std::min(given.size(), bodies), factor.begin());
  if (before == 0.0 || before == dt) return;
  const ContactSet& contacts = stage.contacts();
  std::vector<std::uint8_t> swings(bodies, 0);
  for (std::size_t p = contacts.first_link_pair(); p < contacts.pairs.size(); ++p)
    for (const std::int32_t part : {contacts.pairs[p].part_a, contacts.pairs[p].part_b}) {
      const Body& body = *parts[part].body;
      if (!body.immobile() && interface_of<RigidFrame>(body) != nullptr) swings[parts[part].body_index] = 1;
    }
  std::vector<std::pair<int, int>> touching;
  const auto touch = [&](std::int32_t a, std::int32_t b) {
    const int i = parts[a].body_index, j = parts[b].body_index;
    if (swings[i] || swings[j]) touching.emplace_back(i, j);
  };
  for (std::size_t p = 0; p < contacts.first_link_pair(); ++p)
    if (contacts.pairs[p].begin < contacts.pairs[p].end) touch(contacts.pairs[p].part_a, contacts.pairs[p].part_b);
  stage.rigid().for_pairs(touch);
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto& [a, b] : touching)
      if (swings[a] != swings[b]) swings[a] = swings[b] = 0, changed = true;
  }
  for (std::size_t b = 0; b < bodies; ++b)
    if (swings[b]) factor[b] *= 0.5 * (before + dt) / dt;
}

}  // namespace brim
