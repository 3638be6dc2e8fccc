#include "brim/world/turning.h"

#include <algorithm>
#include <cmath>

#include "brim/body/turns.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

/// Slip, relative to the difference of chord and tangent, up to which a point counts as sticking, and from which on as
/// slipping. What sticks moved along the chord of the last step, or, let go a step ago, along its tangent, and so slips
/// by one or two differences at the start of the next; a disc that spins on a floor slips by 2/(ω dt) of them.
constexpr double kSticks = 2.2, kSlips = 3.0;
/// [rad] turn in a step whose chord is its tangent: 1e-4 of it at most.
constexpr double kStill = 2e-4;

}  // namespace

void Turning::begin(std::span<const WorldPart> parts, const ContactSet& points, std::span<const double> v,
                    std::span<const std::size_t> first_v, double dt) {
  parts_ = parts, dt_ = dt;
  any_ = false;
  const std::size_t bodies = first_v.size() - 1;
  asked_.assign(bodies, 0), turn_.resize(bodies);
  for (const ContactPair& p : points.pairs)
    if (p.begin < p.end)
      for (const std::int32_t part : {p.part_a, p.part_b}) asked_[static_cast<std::size_t>(parts[part].body_index)] = 1;
  std::vector<const Body*> body(bodies, nullptr);
  for (const WorldPart& p : parts) body[static_cast<std::size_t>(p.body_index)] = p.body;
  parallel_for(
      bodies,
      [&](std::size_t b) {
        turn_[b] = {};
        const auto* turns = asked_[b] != 0 && body[b] != nullptr ? interface_of<Turns>(*body[b]) : nullptr;
        if (turns != nullptr) turn_[b] = turns->turn(v.subspan(first_v[b], first_v[b + 1] - first_v[b]));
      },
      64);
  any_ = std::ranges::any_of(turn_, [](const Turns::Turn& t) { return t.spin != Vec3::Zero(); });
}

Vec3 Turning::slip(const ContactPair& pair, const Vec3& x, const Vec3& n, const Vec3& u) const {
  if (parts_[pair.part_a].info.conforming || parts_[pair.part_b].info.conforming) return Vec3::Zero();
  // About the normal: what rolls turns about other axes, and its points leave the surface.
  const auto more = [&](std::int32_t part) -> Vec3 {
    const Turns::Turn& t = turn_[static_cast<std::size_t>(parts_[part].body_index)];
    const double angle = dt_ * n.dot(t.spin);
    if (std::abs(angle) < kStill) return Vec3::Zero();
    const Vec3 d = x - t.center, side = n.cross(d);
    return ((std::cos(angle) - 1.0) * (d - n * n.dot(d)) + (std::sin(angle) - angle) * side) / dt_;
  };
  const Vec3 across = more(pair.part_a) - more(pair.part_b);
  const double size = across.norm();
  if (!(size > 0.0)) return Vec3::Zero();
  const double slip = (u - n * n.dot(u)).norm() / size;
  return std::clamp((kSlips - slip) / (kSlips - kSticks), 0.0, 1.0) * across;
}

void Turning::add_slips(const ContactSet& contacts, std::span<const Vec3> normals, std::span<Vec3> velocity_a,
                        std::span<const Vec3> velocity_b) const {
  parallel_for(contacts.first_link_pair(), [&](std::size_t p) {
    const ContactPair& pair = contacts.pairs[p];
    for (std::size_t c = pair.begin; c < pair.end; ++c)
      velocity_a[c] += slip(pair, contacts.point[c], normals[c], velocity_a[c] - velocity_b[c]);
  });
}

}  // namespace brim
