#include "brim/world/turning.h"

#include <algorithm>
#include <cmath>

#include "brim/body/turns.h"
#include "brim/core/interface_of.h"
#include "brim/core/parallel.h"
#include "brim/response/moved_rows.h"

namespace brim {

namespace {

/// Slip, relative to the difference of chord and tangent, up to which a point counts as sticking, and from which on as
/// slipping. What sticks moved along the chord of the last step, or, let go a step ago, along its tangent, and so slips
/// by one or two differences at the start of the next; a disc that spins on a floor slips by 2/(ω dt) of them.
constexpr double kSticks = 2.2, kSlips = 3.0;
/// [1/h] curvature far below which surfaces count as flat: points of contact stay with the material.
constexpr double kHardlyBent = 0.01;

/// [1/m] Sum of the curvatures of both surfaces through a node.
Mat3 bend_of(const ContactSet& s, std::size_t c) {
  const double a = s.gradient_a[c].norm(), b = s.gradient_b[c].norm();
  Mat3 bend = Mat3::Zero();
  if (a > 0.0) bend -= s.curvature_a(c) / a;
  if (b > 0.0) bend -= s.curvature_b(c) / b;
  return bend;
}

}  // namespace

void Turning::begin(std::span<const WorldPart> parts, const ContactSet& points, std::span<const double> v,
                    std::span<const std::size_t> first_v, double dt) {
  parts_ = parts, dt_ = dt;
  asked_.assign(parts.size(), 0), turn_.assign(parts.size(), {});
  for (const ContactPair& p : points.pairs)
    if (p.begin < p.end)
      for (const std::int32_t part : {p.part_a, p.part_b})
        asked_[static_cast<std::size_t>(part - parts[part].index)] = 1;
  parallel_for(
      parts.size(),
      [&](std::size_t p) {
        if (asked_[p] == 0) return;
        if (const auto* turns = interface_of<Turns>(*parts[p].body))
          turns->turns(velocities_of(parts[p], v, first_v),
                       std::span(turn_).subspan(p, static_cast<std::size_t>(parts[p].body->part_count())));
      },
      64);
  any_ = std::ranges::any_of(
      turn_, [](const Turns::Turn& t) { return t.spin != Vec3::Zero() || t.acceleration != Vec3::Zero(); });
}

Vec3 Turning::more(std::int32_t part, const Vec3& x, const Vec3& n) const {
  const Turns::Turn& t = turn_[static_cast<std::size_t>(part)];
  const Vec3 d = x - t.center;
  const double spin = n.dot(t.spin), angle = dt_ * spin;
  // The whole turn about the normal; others to second order: all of (R - 1) d would brake what rolls.
  const Vec3 second = t.acceleration + t.spin_change.cross(d) + t.spin.cross(t.spin.cross(d));
  const double rest_cos = (std::cos(angle) - 1.0) / dt_ + 0.5 * dt_ * spin * spin,
               rest_sin = (std::sin(angle) - angle) / dt_;
  return 0.5 * dt_ * second + rest_cos * d + rest_sin * n.cross(d);
}

Vec3 Turning::rolled(const ContactPair& pair, const Vec3& n, const Mat3& bend) const {
  const Vec3 spin =
      turn_[static_cast<std::size_t>(pair.part_a)].spin - turn_[static_cast<std::size_t>(pair.part_b)].spin;
  if (n.dot(spin) == 0.0 || bend.isZero(0.0)) return Vec3::Zero();
  const Eigen::Matrix<double, 3, 2> across = tangents_of(n);
  const Eigen::Matrix2d C = across.transpose() * bend * across, eye = Eigen::Matrix2d::Identity();
  const double flat = kHardlyBent / pair.h;
  const Eigen::Vector2d rate = (C * C + flat * flat * eye).inverse() * (C * (across.transpose() * spin.cross(n)));
  return 0.5 * dt_ * n.dot(spin) * n.cross(across * rate);
}

Vec3 Turning::slip(const ContactPair& pair, const Vec3& x, const Vec3& n, const Vec3& u, const Mat3& bend) const {
  if (parts_[pair.part_a].info.conforming || parts_[pair.part_b].info.conforming) return Vec3::Zero();
  Vec3 across = more(pair.part_a, x, n) - more(pair.part_b, x, n);
  across += rolled(pair, n, bend) - n * n.dot(across);
  const double size = across.norm();
  if (!(size > 0.0)) return Vec3::Zero();
  const double slip = (u - n * n.dot(u)).norm() / size;
  return std::clamp((kSlips - slip) / (kSlips - kSticks), 0.0, 1.0) * across;
}

void Turning::add_slips(const ContactSet& contacts, std::span<const Vec3> normals, std::span<Vec3> velocity_a,
                        std::span<const Vec3> velocity_b) const {
  parallel_for(contacts.first_link_pair(), [&](std::size_t p) {
    const ContactPair& pair = contacts.pairs[p];
    const bool rolls =
        turn_[static_cast<std::size_t>(pair.part_a)].spin != turn_[static_cast<std::size_t>(pair.part_b)].spin;
    for (std::size_t c = pair.begin; c < pair.end; ++c)
      velocity_a[c] += slip(pair, contacts.point[c], normals[c], velocity_a[c] - velocity_b[c],
                            rolls ? bend_of(contacts, c) : Mat3(Mat3::Zero()));
  });
}

}  // namespace brim
