#include "brim/contact/face_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "brim/contact/edge_finder.h"
#include "brim/core/simd.h"

namespace brim {

namespace {

/// Reach of the search for the directions of edges, times that of points; [voxels] distance from the nearest edge at
/// which the gap is level.
constexpr double kSeen = 1.5, kClear = 0.75;
/// Directions, [rad], and distances, [voxels], are rounded to this: a scene that is moved by whole voxels then moves
/// alike, as rounding does not reach normals in single precision.
constexpr double kRounded = 1.0 / 1024.0;

double rounded(double x, double unit) { return unit * std::round(x / unit); }

/// Two unit vectors perpendicular to each of the first n unit vectors: from the axis most perpendicular to it, and the
/// third.
BRIM_WIDE void frames_across(const Vectors& normal, int n, Vectors& e, Vectors& f) {
  for (int i = 0; i < n; ++i) {
    const double x = normal[0][i], y = normal[1][i], z = normal[2][i];
    const double ax = std::abs(x), ay = std::abs(y), az = std::abs(z);
    const double is_x = (ax <= ay && ax <= az) ? 1.0 : 0.0, is_y = (is_x == 0.0 && ay <= az) ? 1.0 : 0.0,
                 is_z = 1.0 - is_x - is_y;
    const double along = is_x * x + is_y * y + is_z * z;
    const double ex = is_x - x * along, ey = is_y - y * along, ez = is_z - z * along;
    const double inverse = 1.0 / std::sqrt(ex * ex + ey * ey + ez * ez);
    e[0][i] = inverse * ex, e[1][i] = inverse * ey, e[2][i] = inverse * ez;
  }
  for (int i = 0; i < n; ++i)
    for (int r = 0; r < 3; ++r) {
      const int s = (r + 1) % 3, t = (r + 2) % 3;
      f[r][i] = normal[s][i] * e[t][i] - normal[t][i] * e[s][i];
    }
}

/// x += way e
BRIM_WIDE void go(const Vectors& e, const Numbers& way, int n, Vectors& x) {
  for (int i = 0; i < n; ++i)
    for (int r = 0; r < 3; ++r) x[r][i] += way[i] * e[r][i];
}

/// Carries up to kTogether points to edges.
class Carrier {
 public:
  Carrier(const CubeSide& a, const CubeSide& b, double h, double reach) : find_(a, b, h), h_(h), reach_(reach) {}
  /// @param n  unit
  void take(const Vec3& x, const Vec3& n) {
    for (int r = 0; r < 3; ++r) x_[r][count_] = s_.x[r][count_] = x[r], normal_[r][count_] = n[r];
    s_.n = ++count_;
  }
  bool full() const { return count_ == kTogether; }
  void carry() {
    frames_across(normal_, s_.n, s_.e, s_.f);
    find_.gaps(s_, 0.0, s_.level);
    aim();
    // Beside an edge the gap may have begun to rise: searches start further inside.
    for (int i = 0; i < s_.n; ++i) inside_[i] = std::min(0.0, nearest_[i] - kClear * h_);
    go(s_.e, inside_, s_.n, s_.x);
    find_.gaps(s_, 0.0, s_.level);
    find_ways();
    first_ = way_;
    for (int i = 0; i < s_.n; ++i)
      if (first_[i] == 0.0) {  // no edge after all
        for (int r = 0; r < 3; ++r) s_.x[r][i] = x_[r][of_[i]];
      }
    std::swap(s_.e, s_.f);
    find_.gaps(s_, 0.0, s_.level);
    find_ways();
    go(s_.e, way_, s_.n, s_.x);
    go(s_.f, first_, s_.n, s_.x);
    for (int i = 0; i < s_.n; ++i)
      for (int r = 0; r < 3; ++r) x_[r][of_[i]] = s_.x[r][i];
  }
  Vec3 point(int i) const { return {x_[0][i], x_[1][i], x_[2][i]}; }
  void clear() { s_.n = count_ = 0; }

 private:
  /// Turns e towards the nearest edge that a search along e or f meets, f with it, and drops points that meet none.
  void aim() {
    std::fill_n(nearest_.begin(), s_.n, std::numeric_limits<double>::infinity());
    Vectors to = s_.e;
    for ([[maybe_unused]] const int axis : {0, 1}) {
      for (const double sign : {1.0, -1.0}) {
        find_.glimpse(s_, sign, kSeen * reach_, ahead_);
        for (int i = 0; i < s_.n; ++i) {
          if (!(ahead_.way[i] > 0.0)) continue;
          const double turn = rounded(std::atan2(ahead_.across[i], sign * ahead_.along[i]), kRounded),
                       c = std::cos(turn), way = rounded(ahead_.way[i] * std::abs(c), kRounded * h_);
          if (!(way < nearest_[i])) continue;
          nearest_[i] = way;
          for (int r = 0; r < 3; ++r) to[r][i] = c * s_.e[r][i] + std::sin(turn) * s_.f[r][i];
        }
      }
      std::swap(s_.e, s_.f);
    }
    int kept = 0;
    for (int i = 0; i < s_.n; ++i) {
      if (!std::isfinite(nearest_[i])) continue;
      of_[kept] = i, nearest_[kept] = nearest_[i];
      for (int r = 0; r < 3; ++r) {
        const int s = (r + 1) % 3, t = (r + 2) % 3;
        s_.f[r][kept] = normal_[s][i] * to[t][i] - normal_[t][i] * to[s][i];
        s_.e[r][kept] = to[r][i], s_.x[r][kept] = s_.x[r][i];
      }
      ++kept;
    }
    s_.n = kept;
  }
  /// Signed distances along e, [m]; between two edges to the middle between them.
  void find_ways() {
    find_.find(s_, 1.0, reach_, ahead_), find_.find(s_, -1.0, reach_, behind_);
    for (int i = 0; i < s_.n; ++i) {
      const bool both = ahead_.way[i] > 0.0 && behind_.way[i] > 0.0;
      way_[i] = rounded((both ? 0.5 : 1.0) * (ahead_.way[i] - behind_.way[i]), kRounded * h_);
    }
  }

  EdgeFinder find_;
  double h_, reach_;
  int count_ = 0;
  Vectors x_, normal_;  ///< all points
  Search s_;            ///< those near an edge
  std::array<int, kTogether> of_;
  Ways ahead_, behind_;
  Numbers nearest_, inside_, way_, first_;
};

}  // namespace

void carry_to_edges(const CubeSide& a, const CubeSide& b, double h, double reach, std::span<Vec3> points,
                    std::span<const Vec3> normals) {
  Carrier carrier(a, b, h, reach);
  for (std::size_t first = 0; first < points.size(); first += kTogether) {
    const std::size_t n = std::min<std::size_t>(kTogether, points.size() - first);
    carrier.clear();
    for (std::size_t i = first; i < first + n; ++i) carrier.take(points[i], normals[i]);
    carrier.carry();
    for (std::size_t i = 0; i < n; ++i) points[first + i] = carrier.point(static_cast<int>(i));
  }
}

void carry_to_edges(const CubeSide& a, const CubeSide& b, double h, std::span<Contact> contacts) {
  Carrier carrier(a, b, h, h);
  std::array<std::size_t, kTogether> of;
  for (std::size_t next = 0; next < contacts.size();) {
    carrier.clear();
    int n = 0;
    for (; next < contacts.size() && !carrier.full(); ++next) {
      const Vec3 g = (contacts[next].gradient_a - contacts[next].gradient_b).cast<double>();
      const double length = g.norm();
      if (!(length > 0.0)) continue;
      carrier.take(contacts[next].point, g / length);
      of[n++] = next;
    }
    carrier.carry();
    for (int i = 0; i < n; ++i) contacts[of[i]].point = carrier.point(i);
  }
}

}  // namespace brim
