#include "brim/world/part_filter.h"

#include <algorithm>

#include "brim/core/parallel.h"
#include "brim/world/space.h"

namespace brim {

int PartFilter::add(const TouchRule& rule) {
  rules_.push_back(rule);
  return size() - 1;
}

void PartFilter::meet(std::span<const std::unique_ptr<Body>> bodies) {
  // Bodies met at the same time share their start places.
  std::map<int, std::shared_ptr<StartPlaces>> fresh;
  for (int r = 0; r < size(); ++r)
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const TouchRule& rule = this->rule(r);
      const std::string& name = bodies[b]->name();
      const bool asked = (rule.region_a && name_matches(rule.a, name)) || (rule.region_b && name_matches(rule.b, name));
      const std::pair<int, int> at(r, static_cast<int>(b));
      if (!asked || places_.contains(at) || dynamic_cast<const Space*>(bodies[b].get()) != nullptr) continue;
      std::shared_ptr<StartPlaces>& places = fresh[at.second];
      if (!places) places = std::make_shared<StartPlaces>(*bodies[b]);
      places_[at] = places;
    }
}

void PartFilter::moved() {
  for (const auto& [at, places] : places_) places->moved();
}

void PartFilter::follow(const WorldPart& part) {
  for (const auto& [at, places] : places_)
    if (at.second == part.body_index) places->follow();
}

bool PartFilter::in_region(int region, bool side_b, const WorldPart& part, const Vec3& x) {
  const auto& inside = side_b ? rule(region).region_b : rule(region).region_a;
  if (!inside) return true;
  const auto places = places_.find({region, part.body_index});
  return places != places_.end() && inside(places->second->of(part.index, x));
}

bool PartFilter::touch(const WorldPart& a, const WorldPart& b, const Vec3& x) {
  return a.rules->touch_there(a.sides, b.sides, [&](int region, bool exchanged) {
    return in_region(region, exchanged, a, x) && in_region(region, !exchanged, b, x);
  });
}

bool PartFilter::leaves_some(const WorldPart& a, const WorldPart& b) {
  if (size() == 0 || !concerns(a, b)) return true;
  const Aabb box_a = a.body->bounds(a.index), box_b = b.body->bounds(b.index);
  const Aabb& box = box_a.extent().maxCoeff() < box_b.extent().maxCoeff() ? box_a : box_b;
  if (!box.lo.allFinite() || !box.hi.allFinite()) return true;
  follow(a), follow(b);
  if (touch(a, b, box.center())) return true;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 x;
    for (int axis = 0; axis < 3; ++axis) x[axis] = (corner >> axis & 1) != 0 ? box.hi[axis] : box.lo[axis];
    if (touch(a, b, x)) return true;
  }
  return false;
}

void PartFilter::apply(std::span<const WorldPart> parts, ContactSet& set) {
  const auto of = [&](std::int32_t p) -> const WorldPart& { return parts[static_cast<std::size_t>(p)]; };
  counts_.assign(set.size(), 1);
  bool any = false;
  for (const ContactPair& pair : set.pairs) {
    const WorldPart &a = of(pair.part_a), &b = of(pair.part_b);
    if (!concerns(a, b)) continue;
    follow(a), follow(b);
    parallel_for(
        pair.end - pair.begin, [&](std::size_t i) { counts_[pair.begin + i] = touch(a, b, set.point[pair.begin + i]); },
        64);
    any = any || std::find(counts_.begin() + static_cast<std::ptrdiff_t>(pair.begin),
                           counts_.begin() + static_cast<std::ptrdiff_t>(pair.end),
                           0) != counts_.begin() + static_cast<std::ptrdiff_t>(pair.end);
  }
  if (!any) return;
  ContactSet kept;
  kept.engulfed = set.engulfed;
  for (ContactPair pair : set.pairs) {
    const std::size_t first = kept.size();
    for (std::size_t c = pair.begin; c < pair.end; ++c)
      if (counts_[c] != 0) kept.append(set, c, set.point[c], set.depth[c]);
    if (kept.size() == first && concerns(of(pair.part_a), of(pair.part_b))) continue;
    pair.begin = first, pair.end = kept.size();
    kept.pairs.push_back(pair);
  }
  std::swap(set, kept);
}

}  // namespace brim
