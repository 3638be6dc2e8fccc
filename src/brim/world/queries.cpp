#include "brim/world/queries.h"

#include <cmath>

#include "brim/body/changing_surface.h"
#include "brim/body/spinning_balls.h"
#include "brim/core/interface_of.h"
#include "brim/mesh/convex_gap.h"
#include "brim/mesh/distance.h"

namespace brim {

ShownMatter::ShownMatter(const Body& body) {
  const Display& display = body.display();
  if (const auto* balls = interface_of<SpinningBalls>(body)) {
    for (std::int32_t i = 0; i < balls->balls(); ++i)
      x_.push_back(balls->ball_center(i)), radius_.push_back(balls->ball_radius(i));
    count_ = x_.size();
    return;
  }
  std::vector<Vec3f> shown;
  if (const ChangingSurface* surface = changing_surface(body))
    surface->display_surface(shown, own_);
  else
    display_now(body, shown);
  x_.reserve(shown.size());
  for (const Vec3f& p : shown) x_.push_back(p.cast<double>()), box_.extend(x_.back());
  switch (display.kind) {
    case Display::Kind::Points:
      count_ = x_.size(), same_radius_ = display.radius;
      break;
    case Display::Kind::Lines:
      lines_ = display.lines;
      count_ = lines_.size(), same_radius_ = display.radius;
      break;
    case Display::Kind::Triangles:
      triangles_ = changing_surface(body) != nullptr ? std::span<const Triangle>(own_) : std::span(display.triangles);
      count_ = triangles_.size();
      filled_ = !display.two_sided;
      if (const double thickness = body.part(0).thickness; display.two_sided && std::isfinite(thickness))
        same_radius_ = 0.5 * thickness;
      break;
  }
}

RoundedSimplex ShownMatter::simplex(std::size_t i) const {
  RoundedSimplex s;
  s.radius = radius_.empty() ? same_radius_ : radius_[i];
  if (!triangles_.empty()) {
    const Triangle& t = triangles_[i];
    s.corners = 3, s.corner = {at(t[0]), at(t[1]), at(t[2])};
  } else if (!lines_.empty()) {
    s.corners = 2, s.corner = {at(lines_[i][0]), at(lines_[i][1]), Vec3::Zero()};
  } else {
    s.corners = 1, s.corner = {x_[i], Vec3::Zero(), Vec3::Zero()};
  }
  return s;
}

bool ShownMatter::encloses(const Vec3& p) const {
  if (!(p.cwiseMax(box_.lo).cwiseMin(box_.hi) == p)) return false;
  double turns = 0.0;
  for (const Triangle& t : triangles_) turns += triangle_winding(p, at(t[0]), at(t[1]), at(t[2]));
  return turns > 0.5;
}

std::optional<RayEntry> ShownMatter::enter(const Ray& ray) const {
  const RayEntry within{0.0, -ray.direction};
  if (filled_ && encloses(ray.origin)) return within;
  std::optional<RayEntry> best;
  for (std::size_t i = 0; i < count_; ++i) {
    const RoundedSimplex s = simplex(i);
    double begin = 0.0, end = 0.0;
    if (!clip(ray, s.bounds().inflated(1e-9 * (1.0 + ray.origin.norm())), begin, end)) continue;
    if (s.radius > 0.0 && brim::nearest(ray.origin, s).distance <= 0.0) return within;
    const auto entry = brim::enter(ray, s);
    if (entry && (!best || entry->distance < best->distance)) best = entry;
  }
  return best;
}

NearPoint ShownMatter::nearest(const Vec3& p) const {
  NearPoint best;
  for (std::size_t i = 0; i < count_; ++i) {
    const NearPoint near = brim::nearest(p, simplex(i));
    if (near.distance < best.distance) best = near;
  }
  if (!filled_ || !std::isfinite(best.distance)) return best;
  if (best.distance > 1e-12 * (1.0 + p.norm()) && encloses(p))
    best.distance = -best.distance, best.normal = -best.normal;
  return best;
}

bool ShownMatter::meets_box(const Pose& box, const Vec3& half) const {
  const Aabb own{-half, half};
  const auto corner = [&](const Vec3& direction) -> Vec3 {
    return half.cwiseProduct(direction.unaryExpr([](double x) { return x < 0.0 ? -1.0 : 1.0; }));
  };
  for (std::size_t i = 0; i < count_; ++i) {
    RoundedSimplex s = simplex(i);
    for (Vec3& c : s.corner) c = box.to_local(c);
    if (!s.bounds().overlaps(own)) continue;
    const auto support = [&](const Vec3& direction) { return s.support(direction); };
    if (within_reach(support, corner, s.radius)) return true;
  }
  // No surface in it: the box lies inside or outside as a whole.
  return filled_ && count_ > 0 && encloses(box.translation);
}

}  // namespace brim
