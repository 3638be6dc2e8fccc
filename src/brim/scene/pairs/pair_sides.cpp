#include "brim/scene/pairs/pair_sides.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "brim/body/changing_surface.h"

namespace brim {

namespace {

using PairColumn = std::pair<int, int>;
struct Extent {
  float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
};

PairColumn column_of(const Vec3f& x, double width) {
  return {static_cast<int>(std::floor(x.x() / width)), static_cast<int>(std::floor(x.y() / width))};
}

std::map<PairColumn, Extent> extents(std::span<const Vec3f> points, double width) {
  std::map<PairColumn, Extent> columns;
  for (const Vec3f& x : points) {
    Extent& e = columns[column_of(x, width)];
    e.lowest = std::min(e.lowest, x.z());
    e.highest = std::max(e.highest, x.z());
  }
  return columns;
}

/// Pieces into which a length is cut so that none is longer than the width, at most 400.
int pieces(double length, double width) { return std::clamp(static_cast<int>(std::ceil(length / width)), 1, 400); }

}  // namespace

void PairSides::sample(const Body& body, std::vector<Vec3f>& points) {
  const Display& d = body.display();
  std::vector<Triangle> changing;
  const ChangingSurface* const surface = changing_surface(body);
  if (surface) surface->display_surface(corners_, changing);
  if (!surface) display_now(body, corners_);
  points.clear();
  // Points within the elements, so that no column is jumped over.
  if (d.kind == Display::Kind::Triangles) {
    for (const Triangle& t : surface ? changing : d.triangles.items()) {
      const Vec3f &a = corners_[t[0]], u = corners_[t[1]] - a, v = corners_[t[2]] - a;
      const int n = pieces(std::max(u.norm(), v.norm()), width_);
      for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j) points.push_back(a + (float(i) * u + float(j) * v) / float(n));
    }
  } else if (d.kind == Display::Kind::Lines) {
    for (const auto& line : d.lines) {
      const Vec3f &a = corners_[line[0]], u = corners_[line[1]] - a;
      const int n = pieces(u.norm(), width_);
      for (int i = 0; i <= n; ++i) points.push_back(a + float(i) * u / float(n));
    }
  } else {
    points = corners_;
  }
}

double PairSides::leaked(const Body& lower, const Body& upper) {
  sample(lower, lower_);
  sample(upper, upper_);
  if (lower_.empty() || upper_.empty()) return 0.0;
  const auto below = extents(lower_, width_), above = extents(upper_, width_);
  const auto w = static_cast<float>(width_);
  const bool loose_upper = upper.display().kind == Display::Kind::Points;
  const bool loose_lower = lower.display().kind == Display::Kind::Points;
  std::size_t upper_leaked = 0, lower_leaked = 0;
  for (const Vec3f& x : upper_)
    if (const auto it = below.find(column_of(x, width_)); it != below.end()) {
      const float top = loose_upper ? x.z() + w : above.at(it->first).highest;
      upper_leaked += top < it->second.lowest ? 1 : 0;
    }
  for (const Vec3f& x : lower_)
    if (const auto it = above.find(column_of(x, width_)); it != above.end()) {
      const float bottom = loose_lower ? x.z() - w : below.at(it->first).lowest;
      lower_leaked += bottom > it->second.highest ? 1 : 0;
    }
  return std::max(static_cast<double>(upper_leaked) / static_cast<double>(upper_.size()),
                  static_cast<double>(lower_leaked) / static_cast<double>(lower_.size()));
}

double PairSides::below(const Body& body, double z) {
  sample(body, upper_);
  if (upper_.empty()) return 0.0;
  const auto count = std::ranges::count_if(upper_, [&](const Vec3f& x) { return x.z() < z - width_; });
  return static_cast<double>(count) / static_cast<double>(upper_.size());
}

}  // namespace brim
