#include "brim/world/ball_points.h"

#include "brim/body/spinning_balls.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"

namespace brim {

void place_under_balls(std::span<const WorldPart> parts, std::span<const Vec3> normals, ContactSet& contacts) {
  for (std::size_t p = 0; p < contacts.first_link_pair(); ++p) {
    const ContactPair& pair = contacts.pairs[p];
    const auto* a = interface_of<SpinningBalls>(*parts[pair.part_a].body);
    const auto* b = interface_of<SpinningBalls>(*parts[pair.part_b].body);
    if (a == nullptr && b == nullptr) continue;
    parallel_for(
        pair.end - pair.begin,
        [&](std::size_t i) {
          const std::size_t c = pair.begin + i;
          const Vec3& n = normals[c];  // towards a
          const std::int32_t i_a = contacts.source_a[c], i_b = contacts.source_b[c];
          if (a != nullptr && b != nullptr) {
            const double share = a->ball_radius(i_a) / (a->ball_radius(i_a) + b->ball_radius(i_b));
            contacts.point[c] = (1.0 - share) * a->ball_center(i_a) + share * b->ball_center(i_b);
          } else if (a != nullptr) {
            contacts.point[c] = a->ball_center(i_a) - a->ball_radius(i_a) * n;
          } else {
            contacts.point[c] = b->ball_center(i_b) + b->ball_radius(i_b) * n;
          }
        },
        512);
  }
}

void add_fixed_loads(std::span<const WorldPart> parts, const ContactSet& contacts, std::int32_t body,
                     const std::function<double(std::size_t)>& load_at, std::span<double> load) {
  for (std::size_t p = 0; p < contacts.first_link_pair(); ++p) {
    const ContactPair& pair = contacts.pairs[p];
    const WorldPart &a = parts[pair.part_a], &b = parts[pair.part_b];
    const bool on_a = a.body_index == body && is_fixed(b), on_b = b.body_index == body && is_fixed(a);
    if (!on_a && !on_b) continue;
    const auto& source = on_a ? contacts.source_a : contacts.source_b;
    for (std::size_t c = pair.begin; c < pair.end; ++c) load[static_cast<std::size_t>(source[c])] += load_at(c);
  }
}

}  // namespace brim
