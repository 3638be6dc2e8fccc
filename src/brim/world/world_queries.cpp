// Queries of the present state: rays, nearest points, overlaps.
#include <algorithm>
#include <cmath>

#include "brim/body/posed_shape.h"
#include "brim/body/solid_of.h"
#include "brim/core/error.h"
#include "brim/raster/shape_queries.h"
#include "brim/world/queries.h"
#include "brim/world/world_impl.h"

namespace brim {

/// A body's matter: a solid, or what it shows. `part` is that of a solid, 0 of others.
struct SeenMatter {
  int body = 0, part = 0;
  const Body* of = nullptr;
  const PosedShape* solid = nullptr;
  Aabb box;
};

namespace {

/// The box of what a body shows: that of its parts, and a little more where the surface is finer than its elements.
Aabb shown_box(const Body& body) {
  Aabb box;
  double more = body.display().radius;
  for (int p = 0; p < body.part_count(); ++p) {
    box.extend(body.bounds(p));
    const PartInfo info = body.part(p);
    more = std::max({more, 2.0 * info.voxel_size, std::isfinite(info.thickness) ? 0.5 * info.thickness : 0.0});
  }
  return box.empty() ? box : box.inflated(more + 0.1 * box.extent().maxCoeff());
}

void need_place(const char* query, const char* what, const Vec3& x) {
  if (!x.allFinite())
    throw InputError(
        fmt::format("{}: {} ({}, {}, {}) is not allowed; must be finite", query, what, x.x(), x.y(), x.z()));
}

void need_reach(const char* query, const char* what, double value) {
  if (!(value >= 0.0))
    throw InputError(fmt::format("{}: {} {} is not allowed; must be from 0 [m]", query, what, value));
}

/// Bodies with matter for which `meets` holds, each once.
template <class Meets>
std::vector<int> bodies_that(std::span<const SeenMatter> all, const Aabb& region, const Meets& meets) {
  std::vector<int> out;
  for (const SeenMatter& m : all) {
    if (!out.empty() && out.back() == m.body) continue;
    if (m.box.overlaps(region) && meets(m)) out.push_back(m.body);
  }
  return out;
}

}  // namespace

std::vector<SeenMatter> World::Impl::seen(const BodyFilter& sees) {
  catch_up();
  update_bodies();
  std::vector<SeenMatter> all;
  for (std::size_t b = 0; b < count(); ++b) {
    const int number = static_cast<int>(b);
    if (is_removed(b) || (sees != nullptr && !sees(number))) continue;
    const Body& body = *bodies[b];
    if (body.part_count() > 0 && solid_of(body, 0) != nullptr) {
      for (int p = 0; p < body.part_count(); ++p)
        if (const PosedShape* solid = solid_of(body, p)) all.push_back({number, p, &body, solid, solid->bounds()});
    } else if (const Aabb box = shown_box(body); !box.empty()) {
      all.push_back({number, 0, &body, nullptr, box});
    }
  }
  return all;
}

std::optional<QueryHit> World::raycast(const Vec3& origin, const Vec3& direction, double max_distance,
                                       const BodyFilter& filter) const {
  need_place("raycast", "origin", origin);
  need_place("raycast", "direction", direction);
  const double length = direction.stableNorm();
  if (!(length > 0.0)) throw InputError("raycast: the direction is zero; give one of any length above 0");
  need_reach("raycast", "max_distance", max_distance);
  Ray ray{origin, (direction / length).normalized(), max_distance};
  std::optional<QueryHit> best;
  for (const SeenMatter& m : impl_->seen(filter)) {
    double begin = 0.0, end = 0.0;
    // An infinite box is that of a half-space.
    if (m.box.extent().allFinite() && !clip(ray, m.box, begin, end)) continue;
    const auto entry =
        m.solid != nullptr ? enter(ray, m.solid->shape(), m.solid->pose()) : ShownMatter(*m.of).enter(ray);
    if (!entry || entry->distance > max_distance || (best && !(entry->distance < best->distance))) continue;
    best = QueryHit{m.body, m.part, ray.at(entry->distance), entry->normal, entry->distance};
    ray.length = entry->distance;
  }
  return best;
}

std::optional<QueryHit> World::closest_point(const Vec3& point, double max_distance, const BodyFilter& filter) const {
  need_place("closest_point", "point", point);
  need_reach("closest_point", "max_distance", max_distance);
  std::optional<QueryHit> best;
  for (const SeenMatter& m : impl_->seen(filter)) {
    const double reach = best ? std::min(best->distance, max_distance) : max_distance;
    const double gap = (m.box.lo - point).cwiseMax(point - m.box.hi).cwiseMax(0.0).norm();
    if (gap > 0.0 && gap > reach) continue;
    const NearPoint near =
        m.solid != nullptr ? nearest(point, m.solid->shape(), m.solid->pose()) : ShownMatter(*m.of).nearest(point);
    if (!std::isfinite(near.distance) || near.distance > max_distance || (best && !(near.distance < best->distance)))
      continue;
    best = QueryHit{m.body, m.part, near.point, near.normal, near.distance};
  }
  return best;
}

std::vector<int> World::overlap_ball(const Vec3& center, double radius, const BodyFilter& filter) const {
  need_place("overlap_ball", "center", center);
  need_reach("overlap_ball", "radius", radius);
  Aabb region;
  region.extend(center);
  return bodies_that(impl_->seen(filter), region.inflated(radius), [&](const SeenMatter& m) {
    if (m.solid == nullptr) return ShownMatter(*m.of).nearest(center).distance <= radius;
    return nearest(center, m.solid->shape(), m.solid->pose()).distance <= radius;
  });
}

std::vector<int> World::overlap_box(const Pose& box, const Vec3& extents, const BodyFilter& filter) const {
  need_place("overlap_box", "position", box.translation);
  need_place("overlap_box", "extents", extents);
  if (!(extents.minCoeff() >= 0.0))
    throw InputError(fmt::format("overlap_box: extents ({}, {}, {}) are not allowed; must be from 0 [m]", extents.x(),
                                 extents.y(), extents.z()));
  if (!box.rotation.allFinite() || !box.rotation.isUnitary(1e-6) || box.rotation.determinant() < 0.0)
    throw InputError("overlap_box: the rotation is not one; must be orthogonal, with determinant 1");
  const Vec3 half = 0.5 * extents, reach = box.rotation.cwiseAbs() * half;
  const Aabb region{box.translation - reach, box.translation + reach};
  return bodies_that(impl_->seen(filter), region, [&](const SeenMatter& m) {
    if (m.solid == nullptr) return ShownMatter(*m.of).meets_box(box, half);
    return meets_box(m.solid->shape(), m.solid->pose(), box, half);
  });
}

}  // namespace brim
