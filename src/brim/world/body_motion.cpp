#include "brim/world/body_motion.h"

#include <fmt/format.h>

#include <cmath>

#include "brim/body/changing_surface.h"
#include "brim/body/mass_center.h"
#include "brim/body/movable.h"
#include "brim/body/movable_base.h"

namespace brim {

std::optional<Vec3> center_of_mass(const Body& body) {
  const double m = body.mass();
  if (!std::isfinite(m) || !(m > 0.0)) return std::nullopt;
  if (const auto* known = dynamic_cast<const MassCenter*>(&body)) return known->mass_center();
  std::vector<double> v(body.v_size());
  if (!body.rigid_motion(Vec3::Zero(), Vec3::UnitX(), v)) return std::nullopt;
  const Vec3 about_x = body.linear_momentum(v) / m;  // (0, −z, y)
  body.rigid_motion(Vec3::Zero(), Vec3::UnitY(), v);
  const Vec3 about_y = body.linear_momentum(v) / m;  // (z, 0, −x)
  return Vec3(-about_y.z(), about_x.z(), about_y.x());
}

Vec3 middle_of(const Body& body) {
  if (const auto center = center_of_mass(body)) return *center;
  std::vector<Vec3f> x;
  display_now(body, x);
  Vec3 sum = Vec3::Zero();
  for (const Vec3f& p : x) sum += p.cast<double>();
  return x.empty() ? sum : Vec3(sum / static_cast<double>(x.size()));
}

bool moves_by_base(const Body& body) {
  const auto* movable = dynamic_cast<const Movable*>(&body);
  return dynamic_cast<const MovableBase*>(&body) != nullptr && (movable == nullptr || *movable->bound() != '\0');
}

std::string refuses_move(const Body& body, const Mat3& R) {
  const auto* movable = dynamic_cast<const Movable*>(&body);
  if (movable != nullptr && movable->driven()) return "follows keyframes; it cannot be moved";
  if (moves_by_base(body)) {
    const std::string why = dynamic_cast<const MovableBase&>(body).refuses_turn(R);
    if (why.empty()) return why;
    return why + (R == Mat3::Identity() ? "; it cannot be moved" : "; it cannot be turned");
  }
  if (movable == nullptr)
    return fmt::format("({}) has no place of its own; bodies whose author chose the coordinates are moved by their q",
                       body.kind());
  const std::string why = movable->bound();
  return why.empty() ? why : why + "; it cannot be moved";
}

}  // namespace brim
