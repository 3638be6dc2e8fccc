#include "brim/scene/motion.h"

#include <algorithm>
#include <numbers>

namespace brim {

void check_key_times(const Node& keys) {
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys.at(i).number("time") <= keys.at(i - 1).number("time"))
      throw keys.at(i).at("time").error(
          fmt::format("{} s is not after the keyframe before it, {} s; times must increase", keys.at(i).number("time"),
                      keys.at(i - 1).number("time")));
}

std::vector<MotionKey> read_motion(const Node& keys) {
  std::vector<MotionKey> motion;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Node n = keys.at(i);
    MotionKey key{n.number("time"), n.vec3("offset"), Quat::Identity()};
    if (n.has("rotation")) key.rotation = read_rotation(n.at("rotation"));
    motion.push_back(key);
  }
  return motion;
}

Quat read_rotation(const Node& n) {
  const auto about = [](const Vec3& axis, double degrees) {
    return Quat(Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis));
  };
  if (n.has("axis")) {
    const Vec3 axis = n.vec3("axis");
    if (!(axis.norm() > 1e-12)) throw n.at("axis").error("[0,0,0] is not allowed; must be a direction of some length");
    return about(axis.normalized(), n.number("degrees"));
  }
  if (n.has("quaternion")) {
    const Json& q = n.json().at("quaternion");
    const Quat r(q[0].get<double>(), q[1].get<double>(), q[2].get<double>(), q[3].get<double>());
    if (!(r.norm() > 1e-12))
      throw n.at("quaternion").error("[0,0,0,0] is not allowed; must be [w, x, y, z] of some length");
    return r.normalized();
  }
  const Vec3 e = n.vec3("euler_degrees");
  return about(Vec3::UnitZ(), e.z()) * about(Vec3::UnitY(), e.y()) * about(Vec3::UnitX(), e.x());
}

MotionKey at_time(const std::vector<MotionKey>& keys, double time) {
  if (time <= keys.front().time) return keys.front();
  if (time >= keys.back().time) return keys.back();
  const auto next =
      std::upper_bound(keys.begin(), keys.end(), time, [](double t, const MotionKey& k) { return t < k.time; });
  const MotionKey &a = *(next - 1), &b = *next;
  const double s = (time - a.time) / (b.time - a.time);
  return {time, (1.0 - s) * a.offset + s * b.offset, a.rotation.slerp(s, b.rotation)};
}

}  // namespace brim
