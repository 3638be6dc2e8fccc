#include "brim/world/body_motion.h"

#include <cmath>

#include "brim/body/changing_surface.h"

namespace brim {

std::optional<Vec3> center_of_mass(const Body& body) {
  const double m = body.mass();
  std::vector<double> v(body.v_size());
  if (!std::isfinite(m) || !(m > 0.0) || !body.rigid_motion(Vec3::Zero(), Vec3::UnitX(), v)) return std::nullopt;
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

}  // namespace brim
