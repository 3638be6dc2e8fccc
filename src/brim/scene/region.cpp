#include "brim/scene/region.h"

#include <algorithm>
#include <vector>

namespace brim {

namespace {

constexpr double kFar = 1e9;  // [m]

RegionDistance distance_to(const Node& n) {
  const std::string kind = n.string("kind");
  if (kind == "sphere") {
    const Vec3 center = n.vec3("center");
    const double radius = n.number("radius");
    return [=](const Vec3& x) { return (x - center).norm() - radius; };
  }
  if (kind == "plane") {
    const Vec3 point = n.vec3("point"), normal = n.vec3("normal").normalized();
    return [=](const Vec3& x) { return (x - point).dot(normal); };
  }
  if (kind == "box") {
    const Vec3 lo = n.vec3("lo"), hi = n.vec3("hi");
    return [=](const Vec3& x) {
      const Vec3 d = (lo - x).cwiseMax(x - hi);
      return d.cwiseMax(0.0).norm() + std::min(d.maxCoeff(), 0.0);
    };
  }
  return [](const Vec3&) { return -kFar; };
}

}  // namespace

RegionDistance region_distance(const Node& list) {
  std::vector<RegionDistance> regions;
  for (std::size_t i = 0; i < list.size(); ++i) regions.push_back(distance_to(list.at(i)));
  return [regions](const Vec3& x) {
    double d = kFar;
    for (const RegionDistance& f : regions) d = std::min(d, f(x));
    return d;
  };
}

void check_regions(const Node& list) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Node region = list.at(i);
    const std::string kind = region.string("kind");
    if (kind == "corners") throw region.at("kind").error("\"corners\" are those of a cloth; a fluid has none");
    if (kind == "plane" && !(region.vec3("normal").norm() > 0.0))
      throw region.at("normal").error("has no direction; give one that is not zero");
    if (kind == "box" && !(region.vec3("lo").array() < region.vec3("hi").array()).all())
      throw region.at("hi").error("must be above \"lo\" along every axis");
  }
}

}  // namespace brim
