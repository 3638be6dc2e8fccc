#include "brim/io/polygon_soup.h"

namespace brim {

namespace {

/// Twice the area of the triangle, seen against the normal.
double turn(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal) {
  return (b - a).cross(c - a).dot(normal);
}

}  // namespace

void PolygonSoup::add(std::span<const std::int32_t> corners) {
  const std::size_t n = corners.size();
  if (n < 3) return;
  const auto at = [&](std::size_t i) -> const Vec3& { return vertices[static_cast<std::size_t>(corners[i % n])]; };
  // Newell's normal: right for any polygon that does not cross itself.
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < n; ++i) normal += (at(i) - at(0)).cross(at(i + 1) - at(0));
  bool convex = true;
  for (std::size_t i = 0; n > 3 && i < n; ++i) convex = convex && turn(at(i), at(i + 1), at(i + 2), normal) >= 0.0;
  if (!convex) return cut_ears({corners.begin(), corners.end()}, normal);
  for (std::size_t i = 1; i + 1 < n; ++i) triangles_.push_back({corners[0], corners[i], corners[i + 1]});
}

void PolygonSoup::cut_ears(std::vector<std::int32_t> corners, const Vec3& normal) {
  const auto at = [&](std::size_t i) -> const Vec3& {
    return vertices[static_cast<std::size_t>(corners[i % corners.size()])];
  };
  while (corners.size() > 3) {
    const std::size_t n = corners.size();
    std::size_t ear = n;
    for (std::size_t i = 0; i < n && ear == n; ++i) {
      const Vec3 &a = at(i), &b = at(i + 1), &c = at(i + 2);
      bool good = turn(a, b, c, normal) > 0.0;
      for (std::size_t k = i + 3; good && k < i + n; ++k)
        good =
            !(turn(a, b, at(k), normal) >= 0.0 && turn(b, c, at(k), normal) >= 0.0 && turn(c, a, at(k), normal) >= 0.0);
      if (good) ear = i;
    }
    if (ear == n) ear = 0;  // it crosses itself: any cut is as good as another
    triangles_.push_back({corners[ear], corners[(ear + 1) % n], corners[(ear + 2) % n]});
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>((ear + 1) % n));
  }
  triangles_.push_back({corners[0], corners[1], corners[2]});
}

}  // namespace brim
