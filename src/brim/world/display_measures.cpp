#include "brim/world/display_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace brim {

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

Vec3 corner(const Shown& s, const Triangle& t, std::size_t i) {
  return s.x[static_cast<std::size_t>(t[i])].cast<double>();
}

/// z component of the cross product.
double cross2(const Vec3& a, const Vec3& b) { return a.x() * b.y() - a.y() * b.x(); }

struct Outline {
  double lo[2], hi[2];

  explicit Outline(const Shown& s) {
    for (int a = 0; a < 2; ++a) {
      lo[a] = std::numeric_limits<double>::infinity();
      hi[a] = -lo[a];
      for (const Vec3f& x : s.x) {
        lo[a] = std::min(lo[a], static_cast<double>(x[a]));
        hi[a] = std::max(hi[a], static_cast<double>(x[a]));
      }
    }
  }
  double distance(double x, double y) const { return std::max({lo[0] - x, x - hi[0], lo[1] - y, y - hi[1]}); }
};

}  // namespace

double enclosed_volume(const Shown& body) {
  if (body.triangles.empty()) return kNothing;
  double six = 0.0;
  for (const Triangle& t : body.triangles) six += corner(body, t, 0).dot(corner(body, t, 1).cross(corner(body, t, 2)));
  return six / 6.0;
}

int count_under(const Shown& body, const Shown& sheet) {
  // Flags: 1 for sheet above the point, 2 for sheet below.
  std::vector<unsigned char> sides(body.x.size(), 0);
  for (const Triangle& t : sheet.triangles) {
    const Vec3 a = corner(sheet, t, 0), u = corner(sheet, t, 1) - a, w = corner(sheet, t, 2) - a;
    const double area = cross2(u, w);
    if (area == 0.0) continue;
    const double lo_x = a.x() + std::min({0.0, u.x(), w.x()}), hi_x = a.x() + std::max({0.0, u.x(), w.x()});
    for (std::size_t i = 0; i < body.x.size(); ++i) {
      const Vec3 r = body.x[i].cast<double>() - a;
      if (r.x() + a.x() < lo_x || r.x() + a.x() > hi_x) continue;
      const double s = cross2(r, w) / area, q = cross2(u, r) / area;
      if (s < 0.0 || q < 0.0 || s + q > 1.0) continue;
      sides[i] |= r.z() < s * u.z() + q * w.z() ? 1 : 2;
    }
  }
  return static_cast<int>(std::ranges::count(sides, 1));
}

double surface_level(const Shown& fluid, double width, const Shown* without) {
  std::map<std::pair<int, int>, double> columns;
  for (const Vec3f& x : fluid.x) {
    const std::pair at(static_cast<int>(std::floor(x.x() / width)), static_cast<int>(std::floor(x.y() / width)));
    const auto [it, fresh] = columns.emplace(at, x.z());
    if (!fresh) it->second = std::max(it->second, static_cast<double>(x.z()));
  }
  std::vector<double> heights;
  const Outline outline(without != nullptr ? *without : Shown{});
  for (const auto& [at, z] : columns)
    if (without == nullptr || outline.distance((at.first + 0.5) * width, (at.second + 0.5) * width) > width)
      heights.push_back(z + fluid.radius);
  if (heights.empty()) return kNothing;
  // A median, since a surface bends down at a wall, and drops fly above it.
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::ranges::nth_element(heights, middle);
  return *middle;
}

double vertex_spacing(const Shown& body) {
  if (body.triangles.empty()) return 2.0 * body.radius;
  double sum = 0.0;
  for (const Triangle& t : body.triangles)
    for (std::size_t i = 0; i < 3; ++i) sum += (corner(body, t, i) - corner(body, t, (i + 1) % 3)).norm();
  return sum / (3.0 * static_cast<double>(body.triangles.size()));
}

}  // namespace brim
