#include "brim/world/sense/sensed_points.h"

#include <algorithm>
#include <limits>

#include "brim/core/error.h"
#include "brim/world/touch_rules.h"
#include "brim/world/world.h"

namespace brim {

namespace {

/// The part whose box is nearest to x.
int nearest_part(const Body& body, const Vec3& x) {
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int p = 0; p < body.part_count(); ++p) {
    const Aabb box = body.bounds(p);
    const double d = (x - x.cwiseMax(box.lo).cwiseMin(box.hi)).norm();
    if (d < least) least = d, best = p;
  }
  return best;
}

}  // namespace

int only_body(const World& world, const std::vector<std::string>& words) {
  if (words.size() != 1) throw InputError(fmt::format("{} bodies are named; it is of one body", words.size()));
  int found = -1;
  for (int b = 0; b < world.body_count(); ++b) {
    if (!name_matches(words[0], world.body(b).name())) continue;
    if (found >= 0) throw InputError(fmt::format("\"{}\" stands for several bodies; it is of one body", words[0]));
    found = b;
  }
  if (found < 0) throw InputError(fmt::format("\"{}\" is not a body", words[0]));
  return found;
}

SensedPoints::SensedPoints(const World& world, int b, int part, std::vector<Vec3> x) : body_(b) {
  const Body& body = world.body(b);
  if (part >= body.part_count())
    throw InputError(fmt::format("part {} is not allowed; '{}' has {}", part, body.name(), body.part_count()));
  part_.body = &body;
  part_.body_index = b;
  part_.index = part >= 0 ? part : nearest_part(body, x.front());
  part_.info = body.part(part_.index);
  for (int p = 0; p < world.part_count(); ++p)
    if (world.part(p).body == b && world.part(p).index == part_.index) part_.h = world.voxel_size(p);
  points_ = MatterPoints::of_part(part_, world.options().ramp_voxels * part_.h, world.q(b), std::move(x));
}

void SensedPoints::find_body(const World& world) {
  body_ = -1;
  for (int b = 0; b < world.body_count(); ++b)
    if (&world.body(b) == part_.body) body_ = b;
}

bool SensedPoints::present(const World& world) const { return body_ >= 0 && !world.removed(body_); }

std::span<const Vec3> SensedPoints::positions(const World& world) {
  points_.follow(part_, world.q(body_));
  return points_.positions();
}

std::span<const Vec3> SensedPoints::velocities(const World& world) {
  std::vector<std::int32_t> source(points_.size());
  for (std::size_t i = 0; i < source.size(); ++i) source[i] = points_.source(i);
  part_.body->make_map(part_.index, points_.positions(), source, map_);
  velocity_.resize(points_.size());
  map_->apply(world.v(body_), velocity_);
  return velocity_;
}

}  // namespace brim
