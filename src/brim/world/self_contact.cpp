#include "brim/world/self_contact.h"

#include <algorithm>

#include "brim/core/interface_of.h"
#include "brim/core/profile.h"
#include "brim/world/substeps.h"

namespace brim {

template <class F>
void SelfContact::for_bodies(std::span<const WorldPart> parts, const F& f) {
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const WorldPart& part = parts[p];
    if (part.index != 0 || part.still || is_fixed(part) || !rules_allow(part, part)) continue;
    const auto* body = interface_of<MeetsItself>(*part.body);
    const Body* pieces = body != nullptr ? body->pieces() : nullptr;
    if (pieces == nullptr) continue;
    piece_.assign(static_cast<std::size_t>(pieces->part_count()), part);
    for (std::size_t i = 0; i < piece_.size(); ++i) piece_[i].body = pieces, piece_[i].index = static_cast<int>(i);
    f(static_cast<std::int32_t>(p), *body);
  }
}

void SelfContact::find(std::span<const WorldPart> parts, std::span<const double> v,
                       std::span<const std::size_t> first_v, double dt, const WorldOptions& options, StepReport& report,
                       ContactSet& contacts) {
  for_bodies(parts, [&](std::int32_t part, const MeetsItself& body) {
    const ProfileScope scope("self-contact", *parts[part].body);
    stage_.find(piece_, v, first_v, dt, {}, options, report);
    take(body, part, contacts);
  });
}

void SelfContact::take(const MeetsItself& body, std::int32_t part, ContactSet& contacts) const {
  const ContactSet& found = stage_.contacts();
  for (ContactPair pair : found.pairs) {
    const std::size_t first = contacts.size();
    for (std::size_t c = pair.begin; c < pair.end; ++c) {
      const std::int32_t a = body.source_of(pair.part_a, found.source_a[c]);
      const std::int32_t b = body.source_of(pair.part_b, found.source_b[c]);
      if (a < 0 || b < 0 || !body.may_meet(a, b)) continue;
      contacts.append(found, c, found.point[c], found.depth[c]);
      contacts.source_a.back() = a, contacts.source_b.back() = b;
    }
    if (contacts.size() == first) continue;
    pair.part_a = pair.part_b = part;
    pair.begin = first, pair.end = contacts.size();
    contacts.pairs.push_back(pair);
  }
}

double SelfContact::motion_pieces(std::span<const WorldPart> parts, std::span<const double> v,
                                  std::span<const std::size_t> first_v, const WorldOptions& options, double time,
                                  double change, BoxSweep& sweep) {
  double most = 1.0;
  for_bodies(parts, [&](std::int32_t, const MeetsItself&) {
    most = std::max(most, brim::motion_pieces(piece_, v, first_v, options, time, change, {}, sweep));
  });
  return most;
}

}  // namespace brim
