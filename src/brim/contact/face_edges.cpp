#include "brim/contact/face_edges.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "brim/core/simd.h"

namespace brim {

namespace {

/// [voxels] change of the gap along a face that counts as zero, and possible dip of sampled ones beside an edge.
constexpr double kLevel = 0.02, kDip = 0.04;
/// Smallest slope of the gap beyond an edge.
constexpr double kSteep = 0.5;
/// Bisections of the distance to an edge: 2^-6 of a voxel.
constexpr int kHalvings = 6;
/// [voxels] A sampled distance bends around an edge over one spacing, half a voxel: beyond kBent three points, kBeyond
/// apart, locate the edge if their slopes differ by at most the share kStraight.
constexpr double kBent = 0.6, kBeyond = 0.3, kStraight = 0.12;
/// [voxels] offset to both sides at which the slope along the edge is evaluated; slope above which an edge counts as
/// oblique; [voxels] shift in the second direction above which, for an oblique first edge, it belongs to another edge.
constexpr double kToSide = 0.25, kAslant = 0.2, kOwn = 0.1;
/// Points processed together: about 20 kB, which fits a first-level cache.
constexpr int kTogether = 64;

using Numbers = std::array<double, kTogether>;
using Vectors = std::array<Numbers, 3>;

/// x + t e in the frame of a pose, of the first n points.
BRIM_WIDE void places_along(const Pose& pose, const Vectors& x, const Vectors& e, const Numbers& t, int n,
                            Vectors& local) {
  const Mat3& R = pose.rotation;
  const Vec3& o = pose.translation;
  for (int i = 0; i < n; ++i) {
    const double px = x[0][i] + t[i] * e[0][i] - o[0], py = x[1][i] + t[i] * e[1][i] - o[1],
                 pz = x[2][i] + t[i] * e[2][i] - o[2];
    for (int r = 0; r < 3; ++r) local[r][i] = R(0, r) * px + R(1, r) * py + R(2, r) * pz;
  }
}

/// Points, the search direction of each, the direction across it on the face, and the gap at each, [m].
struct Search {
  Vectors x, e, f;
  Numbers level;
  int n = 0;
  void take(const Search& from, int i) {
    for (int r = 0; r < 3; ++r) x[r][n] = from.x[r][i], e[r][n] = from.e[r][i], f[r][n] = from.f[r][i];
    level[n++] = from.level[i];
  }
  void go_across(double way) {
    for (int i = 0; i < n; ++i)
      for (int r = 0; r < 3; ++r) x[r][i] += way * f[r][i];
  }
};

/// Result of a search for each point, [m]: distance to where the gap begins to rise, and from there to the edge; and
/// the slope of the gap beyond it in the direction across, 0 when the edge is perpendicular to the search.
struct Ways {
  Numbers begin, on, slant;
};

/// Searches along a face that two solids share.
class EdgeFinder {
 public:
  EdgeFinder(const CubeSide& a, const CubeSide& b, double h, double reach)
      : a_(a), b_(b), h_(h), reach_(reach), exact_(a.solid->slack() == 0.0 && b.solid->slack() == 0.0) {}

  /// d_a + d_b at x + t e, [m].
  void gaps(const Search& s, const Numbers& t, Numbers& gap) {
    distances(a_, s, t, gap);
    distances(b_, s, t, other_);
    for (int i = 0; i < s.n; ++i) gap[i] += other_[i];
  }
  void gaps(const Search& s, double t, Numbers& gap) {
    std::fill_n(t_.begin(), s.n, t);
    gaps(s, t_, gap);
  }

  /// Distances from x along sign e; 0 when there is no edge within reach, or no face in the opposite direction.
  void find(const Search& all, double sign, Ways& ways) {
    for (Numbers* w : {&ways.begin, &ways.on, &ways.slant}) std::fill_n(w->begin(), all.n, 0.0);
    // Keep points whose gap rises within reach, and does not change in the opposite direction.
    gaps(all, sign * reach_, gap_);
    rising_.n = near_.n = 0;
    for (int i = 0; i < all.n; ++i)
      if (gap_[i] > all.level[i] + kLevel * h_) rises_[rising_.n] = i, far_[rising_.n] = gap_[i], rising_.take(all, i);
    if (rising_.n == 0) return;
    gaps(rising_, -0.5 * sign * h_, gap_);
    for (int i = 0; i < rising_.n; ++i)
      if (std::abs(gap_[i] - rising_.level[i]) <= kLevel * h_)
        rises_[near_.n] = rises_[i], far_[near_.n] = far_[i], near_.take(rising_, i);
    std::fill_n(lo_.begin(), near_.n, 0.0), std::fill_n(hi_.begin(), near_.n, reach_);
    for (int k = 0; k < kHalvings; ++k) {
      for (int i = 0; i < near_.n; ++i) t_[i] = 0.5 * (sign * (lo_[i] + hi_[i]));
      gaps(near_, t_, gap_);
      for (int i = 0; i < near_.n; ++i)
        (gap_[i] <= near_.level[i] + kLevel * h_ ? lo_ : hi_)[i] = 0.5 * (lo_[i] + hi_[i]);
    }
    // A ridge in between is no face; sampled distances dip beside an edge.
    for (int i = 0; i < near_.n; ++i) t_[i] = 0.5 * sign * lo_[i];
    gaps(near_, t_, gap_);
    const double dip = (exact_ ? kLevel : kDip) * h_;
    for (int i = 0; i < near_.n; ++i) face_[i] = gap_[i] >= near_.level[i] - dip;
    if (exact_) {
      for (int i = 0; i < near_.n; ++i)
        if (face_[i] && far_[i] - near_.level[i] >= kSteep * (reach_ - lo_[i]))
          ways.begin[rises_[i]] = std::max(0.0, lo_[i] - kLevel * h_);
      return;
    }
    // Beyond an edge the gap rises along a line; the edge is where this line meets the level of the face.
    const auto beyond = [&](int k, Numbers& gap) {
      for (int i = 0; i < near_.n; ++i) t_[i] = sign * (lo_[i] + (kBent + k * kBeyond) * h_);
      gaps(near_, t_, gap);
    };
    for (int k = 0; k < 3; ++k) beyond(k, beyond_[k]);
    for (const double side : {1.0, -1.0}) {
      near_.go_across(side * kToSide * h_);
      beyond(1, side > 0.0 ? left_ : right_);
      near_.go_across(-side * kToSide * h_);
    }
    for (int i = 0; i < near_.n; ++i) {
      if (!face_[i]) continue;
      const int of = rises_[i];
      const double begin = std::max(0.0, lo_[i] - kLevel * h_), rise = beyond_[0][i] - near_.level[i],
                   slope = (beyond_[1][i] - beyond_[0][i]) / (kBeyond * h_),
                   further = (beyond_[2][i] - beyond_[1][i]) / (kBeyond * h_),
                   edge = lo_[i] + kBent * h_ - rise / std::max(kSteep, slope);
      if (slope >= kSteep && std::abs(further - slope) <= kStraight * slope) {
        if (edge > reach_) continue;
        ways.begin[of] = begin, ways.on[of] = std::max(0.0, edge - begin);
        // Beside a corner it changes on one side only.
        ways.slant[of] =
            std::min(std::abs(left_[i] - beyond_[1][i]), std::abs(right_[i] - beyond_[1][i])) / (kToSide * h_);
      } else if (far_[i] - near_.level[i] >= kSteep * (reach_ - lo_[i])) {
        ways.begin[of] = begin;
      }
    }
  }

 private:
  void distances(const CubeSide& side, const Search& s, const Numbers& t, Numbers& d) {
    places_along(side.pose, s.x, s.e, t, s.n, local_);
    side.solid->distances({local_[0].data(), local_[1].data(), local_[2].data(), s.n}, d.data());
  }

  const CubeSide &a_, &b_;
  double h_, reach_;
  bool exact_;  ///< distances are exact, not sampled: they rise right at edges
  Search rising_, near_;
  std::array<int, kTogether> rises_;
  std::array<bool, kTogether> face_;
  std::array<Numbers, 3> beyond_;
  Numbers far_, lo_, hi_, gap_, other_, left_, right_, t_;
  Vectors local_;
};

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
  Carrier(const CubeSide& a, const CubeSide& b, double h, double reach) : find_(a, b, h, reach), h_(h) {}
  /// @param n  unit
  void take(const Vec3& x, const Vec3& n) {
    for (int r = 0; r < 3; ++r) s_.x[r][s_.n] = x[r], normal_[r][s_.n] = n[r];
    ++s_.n;
  }
  bool full() const { return s_.n == kTogether; }
  void carry() {
    frames_across(normal_, s_.n, s_.e, s_.f);
    find_.gaps(s_, 0.0, s_.level);
    find_ways();
    // The rest of the way to the edge is applied last: beside it the gap has risen already, which hides the other edge.
    first_ = s_.e, rest_ = on_;
    for (int i = 0; i < s_.n; ++i) aslant_[i] = rest_[i] != 0.0 && slant_[i] > kAslant;
    go(s_.e, way_, s_.n, s_.x);
    std::swap(s_.e, s_.f);
    find_ways();
    for (int i = 0; i < s_.n; ++i)
      if (!aslant_[i] || std::abs(way_[i]) > kOwn * h_) way_[i] += on_[i];  // else it is the same edge
    go(s_.e, way_, s_.n, s_.x);
    go(first_, rest_, s_.n, s_.x);
  }
  Vec3 point(int i) const { return {s_.x[0][i], s_.x[1][i], s_.x[2][i]}; }
  void clear() { s_.n = 0; }

 private:
  /// Signed distances along e, [m]; between two edges to the middle between them.
  void find_ways() {
    find_.find(s_, 1.0, ahead_), find_.find(s_, -1.0, behind_);
    for (int i = 0; i < s_.n; ++i) {
      const bool both = ahead_.begin[i] > 0.0 && behind_.begin[i] > 0.0;
      way_[i] = (both ? 0.5 : 1.0) * (ahead_.begin[i] - behind_.begin[i]);
      on_[i] = both ? 0.0 : ahead_.on[i] - behind_.on[i];
      slant_[i] = ahead_.slant[i] + behind_.slant[i];
    }
  }
  EdgeFinder find_;
  double h_;
  Search s_;
  Vectors normal_, first_;
  Ways ahead_, behind_;
  Numbers way_, on_, slant_, rest_;
  std::array<bool, kTogether> aslant_;
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
