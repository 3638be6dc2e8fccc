#include "brim/world/turning.h"

#include <algorithm>

#include "brim/body/turns.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/math/rotation.h"

namespace brim {

namespace {

/// Slip, relative to the difference of chord and tangent, up to which a point counts as sticking, and from which on as
/// slipping. What sticks moves along the chord of the last step, and so slips by one difference at the start of the
/// next; a disc that spins on a floor slips by 2/(ω dt) of them.
constexpr double kSticks = 2.2, kSlips = 3.0;

}  // namespace

void Turning::begin(std::span<const WorldPart> parts, const ContactSet& points, std::span<const double> v,
                    std::span<const std::size_t> first_v, double dt) {
  parts_ = parts;
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
        turn_[b].more.setZero();
        const auto* turns = asked_[b] != 0 && body[b] != nullptr ? interface_of<Turns>(*body[b]) : nullptr;
        if (turns == nullptr) return;
        const Turns::Turn t = turns->turn(v.subspan(first_v[b], first_v[b + 1] - first_v[b]));
        if (t.spin == Vec3::Zero()) return;
        Mat3 cross;
        cross << 0.0, -t.spin.z(), t.spin.y(), t.spin.z(), 0.0, -t.spin.x(), -t.spin.y(), t.spin.x(), 0.0;
        turn_[b] = {t.center, (rotation_from_vector(dt * t.spin).toRotationMatrix() - Mat3::Identity()) / dt - cross};
      },
      64);
  any_ = std::ranges::any_of(turn_, [](const Turn& t) { return t.more != Mat3::Zero(); });
}

Vec3 Turning::slip(const ContactPair& pair, const Vec3& x, const Vec3& n, const Vec3& u) const {
  if (parts_[pair.part_a].info.conforming || parts_[pair.part_b].info.conforming) return Vec3::Zero();
  const Turn &a = of(pair.part_a), &b = of(pair.part_b);
  const Vec3 more = a.more * (x - a.center) - b.more * (x - b.center), across = more - n * n.dot(more);
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
