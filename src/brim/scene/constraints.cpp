#include "brim/scene/constraints.h"

#include <algorithm>
#include <functional>

#include "brim/scene/motion.h"

namespace brim {

namespace {

using Inside = std::function<bool(const Vec3&)>;

Inside region(const Node& n) {
  const std::string kind = n.string("kind");
  // Points that lie on the border but for rounding belong to the region.
  constexpr double kSlack = 1e-9;
  if (kind == "box")
    return [lo = n.vec3("lo"), hi = n.vec3("hi")](const Vec3& x) {
      return ((x - lo).array() >= -kSlack).all() && ((hi - x).array() >= -kSlack).all();
    };
  if (kind == "sphere")
    return [c = n.vec3("center"), r = n.number("radius")](const Vec3& x) { return (x - c).norm() <= r + kSlack; };
  if (kind == "plane")
    return [p = n.vec3("point"), d = n.vec3("normal").normalized().eval()](const Vec3& x) {
      return (x - p).dot(d) <= kSlack;
    };
  return [](const Vec3&) { return true; };
}

/// The selected nodes move as one: turned about their middle, then shifted.
NodeMotion keyed_motion(std::vector<std::int32_t> nodes, std::vector<MotionKey> keys, std::span<const Vec3> rest) {
  Vec3 middle = Vec3::Zero();
  for (const std::int32_t i : nodes) middle += rest[static_cast<std::size_t>(i)];
  middle /= static_cast<double>(nodes.size());
  return {std::move(nodes), [keys = std::move(keys), middle](double time, const Vec3& x) -> Vec3 {
            const MotionKey k = at_time(keys, time);
            return middle + k.offset + k.rotation * (x - middle);
          }};
}

}  // namespace

std::function<bool(const Vec3&)> read_region(const Node& n) {
  if (n.string("kind") == "corners")
    throw n.error("\"corners\" is not allowed here; must be box, sphere, plane or all");
  return region(n);
}

void check_constraints(const Node& list, bool has_corners) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node n = list.at(i), select = n.at("select");
    const std::string kind = select.string("kind");
    if (kind == "corners" && !has_corners)
      throw select.error(
          "\"corners\" is not allowed here; only a grid has corners, other bodies take box, sphere, "
          "plane or all");
    if (kind == "box" && (select.vec3("lo").array() > select.vec3("hi").array()).any())
      throw select.at("lo").error(fmt::format("{} is not allowed; must be at most \"hi\", {}, along each axis",
                                              shown(select.at("lo").json()), shown(select.at("hi").json())));
    if (kind == "plane" && !(select.vec3("normal").norm() > 1e-12))
      throw select.at("normal").error("[0,0,0] is not allowed; must be a direction of some length");
    if (!n.has("keyframes")) continue;
    if (n.vec3("velocity") != Vec3::Zero())
      throw n.at("velocity").error("both \"velocity\" and \"keyframes\" are given; give one of them");
    check_key_times(n.at("keyframes"));
  }
}

std::vector<HeldRegion> read_constraints(const Node& list, std::span<const Vec3> rest,
                                         std::span<const std::int32_t> corners, const Quat& turned,
                                         ParticleOptions& options) {
  std::vector<HeldRegion> held;
  std::vector<char> taken(rest.size(), 0);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node n = list.at(i), select = n.at("select");
    std::vector<std::int32_t> nodes;
    const auto take = [&](std::int32_t node) {
      if (!std::exchange(taken[static_cast<std::size_t>(node)], 1)) nodes.push_back(node);
    };
    bool any = false;
    if (select.string("kind") == "corners") {
      for (const int c : select.at("which").integers()) take(corners[static_cast<std::size_t>(c)]);
      any = true;
    } else {
      const Inside inside = region(select);
      for (std::size_t k = 0; k < rest.size(); ++k)
        if (inside(rest[k])) {
          any = true;
          take(static_cast<std::int32_t>(k));
        }
    }
    if (!any) {
      Aabb box;
      for (const Vec3& x : rest) box.extend(x);
      throw select.error(
          fmt::format("selects no point of the body; its points lie in [{:.4g}, {:.4g}, {:.4g}] to "
                      "[{:.4g}, {:.4g}, {:.4g}]",
                      box.lo.x(), box.lo.y(), box.lo.z(), box.hi.x(), box.hi.y(), box.hi.z()));
    }
    if (nodes.empty()) continue;
    if (select.string("kind") != "corners") held.push_back({nodes, region(select)});
    const Vec3 velocity = turned * n.vec3("velocity");
    if (n.has("keyframes"))
      options.motions.push_back(keyed_motion(std::move(nodes), read_motion(n.at("keyframes"), turned), rest));
    else if (velocity != Vec3::Zero())
      options.motions.push_back(NodeMotion::constant_velocity(std::move(nodes), velocity));
    else
      options.fixed.insert(options.fixed.end(), nodes.begin(), nodes.end());
  }
  return held;
}

}  // namespace brim
