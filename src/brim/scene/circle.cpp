#include "brim/scene/circle.h"

#include <cmath>
#include <numbers>

namespace brim {

namespace {

/// [degrees] Copies that are closer lie on each other.
constexpr double kSamePlace = 1e-6;

/// The first copy after the first one that lies on it, or 0.
int copy_on_first(int count, double degrees) {
  for (int k = 1; k < count; ++k)
    if (std::abs(std::remainder(k * degrees, 360.0)) < kSamePlace) return k;
  return 0;
}

}  // namespace

Placement Circle::place(const Placement& first, int k) const {
  if (k == 0) return first;
  const Quat turn(Eigen::AngleAxisd(k * degrees * std::numbers::pi / 180.0, axis));
  Placement p = first;
  p.position = point + turn * (first.position - point);
  p.rotation = turn * first.rotation;
  p.turned = turn * first.turned;
  p.velocity = turn * first.velocity;
  p.angular_velocity = turn * first.angular_velocity;
  return p;
}

Circle read_circle(const Node& around) {
  Circle circle;
  circle.point = around.vec3("point");
  circle.axis = around.vec3("axis");
  if (!(circle.axis.norm() > 1e-12))
    throw around.at("axis").error("[0,0,0] is not allowed; must be a direction of some length");
  circle.axis.normalize();
  circle.count = static_cast<int>(around.integer("count"));
  circle.degrees = around.number_if("degrees").value_or(360.0 / circle.count);
  if (const int k = copy_on_first(circle.count, circle.degrees); k > 0)
    throw around.at("degrees").error(fmt::format(
        "{:.6g} degrees from one copy to the next put copy {} on copy 0; {} copies share a whole circle by {:.6g} "
        "degrees, which is also what they get without \"degrees\"",
        circle.degrees, k, circle.count, 360.0 / circle.count));
  return circle;
}

}  // namespace brim
