#include "brim/raster/shape_queries.h"

#include <algorithm>
#include <cmath>

#include "brim/mesh/convex_gap.h"
#include "brim/raster/convex_distance.h"
#include "brim/raster/known_distance.h"

namespace brim {

namespace {

/// Sampled distances are up to 2 % too large far from the surface (make_distance_grid).
constexpr double kTooFar = 1.02;
constexpr double kLeastStep = 1e-5;  ///< of the solid's size, along a ray
constexpr double kOnSurface = 1e-13;
constexpr int kMostProjections = 100;

/// A shape with what its queries need.
struct Asked {
  const Shape& shape;
  const ConvexDistance* convex = nullptr;
  bool formula = false;
  double size = 1.0;  ///< [m]
  double step = 0.0;  ///< [m] of differences

  Asked(const Shape& s, const Vec3& near) : shape(s) {
    const auto* known = dynamic_cast<const KnownDistance*>(&s);
    if (known != nullptr) convex = known->convex(), formula = known->by_rows();
    const double diagonal = s.bounds().extent().norm();
    size = std::isfinite(diagonal) ? diagonal : 1.0 + near.norm();
    step = formula || known == nullptr ? 1e-7 * size : 1e-3 * known->slack();
  }

  double distance(const Vec3& p) const { return shape.distance(p); }

  /// Gradient of the distance; shorter than 1 where the nearest point is not the only one.
  Vec3 slope(const Vec3& p) const {
    Vec3 g;
    for (int i = 0; i < 3; ++i) {
      const Vec3 d = step * Vec3::Unit(i);
      g[i] = (distance(p + d) - distance(p - d)) / (2.0 * step);
    }
    return g;
  }

  /// Unit normal at or near the surface.
  Vec3 normal(const Vec3& p) const {
    Vec3 g = Vec3::Zero();
    if (convex != nullptr) convex->distance_and_gradient(p, g);
    if (!(g.squaredNorm() > 0.25)) g = slope(p);
    return g.squaredNorm() > 1e-12 ? Vec3(g.normalized()) : Vec3::UnitZ();
  }

  /// Moves a point along the gradient to the surface.
  Vec3 project(Vec3 x) const {
    for (int i = 0; i < kMostProjections; ++i) {
      const double d = distance(x);
      if (std::abs(d) <= kOnSurface * (size + x.norm())) break;
      Vec3 g = Vec3::Zero();
      if (convex != nullptr) convex->distance_and_gradient(x, g);
      if (!(g.squaredNorm() > 0.25)) g = slope(x);
      // A ridge of the distance: a step aside has one nearest point.
      if (!(g.norm() > 0.9)) g = slope(x + 1e-6 * size * Vec3(0.8, 0.5, 0.3));
      if (!(g.squaredNorm() > 1e-12)) break;
      x -= d * g.normalized();
    }
    return x;
  }
};

/// Newton's steps on a convex function of the way, from outside: its tangents lie below it.
std::optional<RayEntry> enter_convex(const Ray& ray, const Asked& a, double begin) {
  double t = begin;
  for (int i = 0; i < kMostProjections; ++i) {
    Vec3 g = Vec3::Zero();
    const Vec3 p = ray.at(t);
    const double d = a.convex->distance_and_gradient(p, g);
    if (d <= kOnSurface * (a.size + p.norm())) return RayEntry{t, a.normal(p)};
    const double rate = g.dot(ray.direction);
    if (!(rate < 0.0)) return {};
    const double next = t - d / rate;
    if (!(next <= ray.length)) return {};
    if (next == t) return RayEntry{t, a.normal(p)};
    t = next;
  }
  return {};  // along the surface, without meeting it
}

std::optional<RayEntry> enter_any(const Ray& ray, const Asked& a, double begin, double end) {
  const double least = kLeastStep * a.size;
  double t = begin, outside = begin;
  while (true) {
    const double d = a.distance(ray.at(t));
    if (d <= 0.0) break;
    if (!(t < end)) return {};
    outside = t;
    // Far from the origin a short step may be less than rounding.
    const double next = t + std::max(a.formula ? d : d / kTooFar, least);
    t = std::min(std::max(next, std::nextafter(t, end)), end);
  }
  for (int i = 0; i < 100 && t > outside; ++i) {
    const double middle = 0.5 * (outside + t);
    if (middle == outside || middle == t) break;
    (a.distance(ray.at(middle)) <= 0.0 ? t : outside) = middle;
  }
  return RayEntry{t, a.normal(ray.at(t))};
}

/// Slides a point of the surface to where the line to p is normal to it.
Vec3 slide(const Asked& a, const Vec3& p, Vec3 x) {
  double share = 1.0;
  for (int i = 0; i < kMostProjections && share > 1e-3; ++i) {
    const Vec3 n = a.normal(x), way = p - x, aside = way - n.dot(way) * n;
    if (!(aside.norm() > 1e-9 * a.size)) break;
    const Vec3 next = a.project(x + share * aside);
    if ((p - next).norm() < way.norm())
      x = next, share = std::min(1.0, 2.0 * share);
    else
      share *= 0.5;
  }
  return x;
}

/// A solid and a box in the box's frame.
struct BoxSearch {
  const Asked& a;
  const Pose& shape_in_box;
  const Vec3& half;

  bool inside(const Vec3& x) const { return (x.cwiseAbs() - half).maxCoeff() <= 1e-12 * half.maxCoeff(); }

  bool meets(const Vec3& center, const Vec3& piece, int level) const {
    const Vec3 local = shape_in_box.to_local(center);
    const double d = a.distance(local);
    if (d <= 0.0) return true;
    if (d > (a.formula ? 1.0 : kTooFar) * piece.norm()) return false;
    if (inside(shape_in_box.rotation * a.project(local) + shape_in_box.translation)) return true;
    constexpr int kFinest = 7;
    if (level == kFinest) return false;
    for (int i = 0; i < 8; ++i) {
      const Vec3 side((i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5, (i & 4) != 0 ? 0.5 : -0.5);
      if (meets(center + side.cwiseProduct(piece), 0.5 * piece, level + 1)) return true;
    }
    return false;
  }
};

}  // namespace

std::optional<RayEntry> enter(const Ray& given, const Shape& shape, const Pose& pose) {
  const Ray ray{pose.to_local(given.origin), pose.rotation.transpose() * given.direction, given.length};
  const Asked a(shape, ray.origin);
  double begin = 0.0, end = ray.length;
  if (const Aabb box = shape.bounds(); !shape.half_space() && !clip(ray, box, begin, end)) return {};
  if (a.distance(ray.origin) <= 0.0) return RayEntry{0.0, -given.direction};
  if (a.convex == nullptr && !std::isfinite(end)) return {};
  std::optional<RayEntry> entry = a.convex != nullptr ? enter_convex(ray, a, begin) : enter_any(ray, a, begin, end);
  if (entry) entry->normal = pose.rotation * entry->normal;
  return entry;
}

NearPoint nearest(const Vec3& p, const Shape& shape, const Pose& pose) {
  const Vec3 local = pose.to_local(p);
  const Asked a(shape, local);
  NearPoint out;
  out.distance = a.distance(local);
  Vec3 x = a.project(local);
  if (!a.formula) {
    x = slide(a, local, x);
    out.distance = std::copysign((x - local).norm(), out.distance);
  }
  const Vec3 way = local - x;
  // The direction to the point is the normal, and better than a difference; at an edge it is the one that was asked
  // for.
  out.normal = way.norm() > 1e-6 * a.size ? Vec3(std::copysign(1.0, out.distance) * way.normalized()) : a.normal(x);
  out.point = pose.rotation * x + pose.translation;
  out.normal = pose.rotation * out.normal;
  return out;
}

bool meets_box(const Shape& shape, const Pose& pose, const Pose& box, const Vec3& half) {
  const Pose in_box{box.rotation.transpose() * pose.rotation, box.to_local(pose.translation)};
  const Asked a(shape, pose.to_local(box.translation));
  const auto corner = [&](const Vec3& direction) -> Vec3 {
    return half.cwiseProduct(direction.unaryExpr([](double x) { return x < 0.0 ? -1.0 : 1.0; }));
  };
  if (shape.half_space()) {
    const Vec3 up = in_box.rotation.col(2);
    return up.dot(corner(-up) - in_box.translation) <= 0.0;
  }
  if (a.convex == nullptr) return BoxSearch{a, in_box, half}.meets(Vec3::Zero(), half, 0);
  const auto solid = [&](const Vec3& direction) -> Vec3 {
    return in_box.rotation * a.convex->support(in_box.rotation.transpose() * direction) + in_box.translation;
  };
  return within_reach(solid, corner, 0.0);
}

}  // namespace brim
