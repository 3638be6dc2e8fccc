#include "brim/scene/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace brim {

namespace {

/// Angle between two keys of one axis from which keys are added between them, and the largest angle then, [degrees].
/// The short way between two rotations is the one meant below 180.
constexpr double kLongWay = 179.9, kBetween = 90.0;
/// Axes whose directions differ by less are the same.
constexpr double kSameAxis = 1e-9;

/// A rotation about an axis that may be more than one turn.
struct Turn {
  Vec3 axis;  ///< unit; zero: any
  double degrees;
};

Quat about(const Vec3& axis, double degrees) {
  return Quat(Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis));
}

/// Of the rotations of keys that are about one axis; empty for others.
std::optional<Turn> turn_of_key(const Node& key) {
  if (!key.has("rotation")) return Turn{Vec3::Zero(), 0.0};
  const Node n = key.at("rotation");
  if (n.has("quaternion")) return std::nullopt;
  if (n.has("axis"))
    return Turn{n.number("degrees") == 0.0 ? Vec3(Vec3::Zero()) : n.vec3("axis").normalized(), n.number("degrees")};
  const Vec3 e = n.vec3("euler_degrees");
  Eigen::Index most = 0;
  e.cwiseAbs().maxCoeff(&most);
  if (e.cwiseAbs().sum() != std::abs(e[most])) return std::nullopt;
  return Turn{e[most] == 0.0 ? Vec3(Vec3::Zero()) : Vec3(Vec3::Unit(most)), e[most]};
}

Quat rotation_of_key(const Node& key) {
  return key.has("rotation") ? read_rotation(key.at("rotation")) : Quat::Identity();
}

/// Adds keys before `last` where the angle between the keys is too large for the short way.
/// @param from, to  turns of the last key of the motion, and of `last`
void add_between(std::vector<MotionKey>& motion, const Turn& from, const Turn& to, const MotionKey& last) {
  const Vec3 axis = from.axis.isZero() ? to.axis : from.axis;
  const double way = axis.dot(to.axis) < 0.0 ? -to.degrees : to.degrees, degrees = way - from.degrees;
  if (!to.axis.isZero() && axis.cross(to.axis).norm() > kSameAxis) return;
  if (!(std::abs(degrees) > kLongWay)) return;
  const MotionKey first = motion.back();
  const double pieces = std::ceil(std::abs(degrees) / kBetween);
  for (double k = 1.0; k < pieces; ++k) {
    const double s = k / pieces;
    motion.push_back({(1.0 - s) * first.time + s * last.time, (1.0 - s) * first.offset + s * last.offset,
                      about(axis, from.degrees + s * degrees)});
  }
}

}  // namespace

void check_key_times(const Node& keys) {
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys.at(i).number("time") <= keys.at(i - 1).number("time"))
      throw keys.at(i).at("time").error(
          fmt::format("{} s is not after the keyframe before it, {} s; times must increase", keys.at(i).number("time"),
                      keys.at(i - 1).number("time")));
}

std::vector<MotionKey> read_motion(const Node& keys, const Quat& turned) {
  std::vector<MotionKey> motion;
  std::optional<Turn> before;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const Node n = keys.at(i);
    const MotionKey key{n.number("time"), n.vec3("offset"), rotation_of_key(n)};
    const std::optional<Turn> turn = turn_of_key(n);
    if (i > 0 && before && turn) add_between(motion, *before, *turn, key);
    motion.push_back(key);
    before = turn;
  }
  for (MotionKey& key : motion) {
    key.offset = turned * key.offset;
    key.rotation = turned * key.rotation * turned.conjugate();
  }
  return motion;
}

Quat read_rotation(const Node& n) {
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
