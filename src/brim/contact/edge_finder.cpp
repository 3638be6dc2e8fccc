#include "brim/contact/edge_finder.h"

#include <algorithm>
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
/// [voxels] offset to both sides at which the slope across a search is evaluated, of sampled and of exact distances;
/// place beyond an edge at which that of exact ones is.
constexpr double kToSide = 0.25, kToSideExact = 0.05, kBeyondExact = 0.3;

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

}  // namespace

EdgeFinder::EdgeFinder(const CubeSide& a, const CubeSide& b, double h)
    : a_(a), b_(b), h_(h), exact_(a.solid->slack() == 0.0 && b.solid->slack() == 0.0) {}

void EdgeFinder::gaps(const Search& s, const Numbers& t, Numbers& gap) {
  distances(a_, s, t, gap);
  distances(b_, s, t, other_);
  for (int i = 0; i < s.n; ++i) gap[i] += other_[i];
}

void EdgeFinder::gaps(const Search& s, double t, Numbers& gap) {
  std::fill_n(t_.begin(), s.n, t);
  gaps(s, t_, gap);
}

void EdgeFinder::find(const Search& all, double sign, double reach, bool loosely, Ways& ways) {
  for (Numbers* w : {&ways.way, &ways.along, &ways.across}) std::fill_n(w->begin(), all.n, 0.0);
  // Keep points whose gap rises within reach, and does not change in the opposite direction.
  gaps(all, sign * reach, gap_);
  rising_.n = near_.n = 0;
  for (int i = 0; i < all.n; ++i)
    if (gap_[i] > all.level[i] + kLevel * h_) rises_[rising_.n] = i, rising_.take(all, i);
  if (rising_.n == 0) return;
  if (!loosely) gaps(rising_, -0.5 * sign * h_, gap_);
  for (int i = 0; i < rising_.n; ++i)
    if (loosely || std::abs(gap_[i] - rising_.level[i]) <= kLevel * h_)
      rises_[near_.n] = rises_[i], near_.take(rising_, i);
  if (near_.n == 0) return;
  std::fill_n(lo_.begin(), near_.n, 0.0), std::fill_n(hi_.begin(), near_.n, reach);
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
  exact_ ? locate_exact(sign, ways) : locate_sampled(sign, reach, ways);
}

void EdgeFinder::beyond(double sign, double distance, Numbers& gap) {
  for (int i = 0; i < near_.n; ++i) t_[i] = sign * (lo_[i] + distance * h_);
  gaps(near_, t_, gap);
}

void EdgeFinder::beside(double sign, double distance, double to_side) {
  for (const double side : {1.0, -1.0}) {
    near_.go_across(side * to_side * h_);
    beyond(sign, distance, side > 0.0 ? left_ : right_);
    near_.go_across(-side * to_side * h_);
  }
}

void EdgeFinder::locate_exact(double sign, Ways& ways) {
  beside(sign, kBeyondExact, kToSideExact);
  beyond(sign, kBeyondExact - kToSideExact, beyond_[0]), beyond(sign, kBeyondExact + kToSideExact, beyond_[1]);
  for (int i = 0; i < near_.n; ++i) {
    const double slope = (beyond_[1][i] - beyond_[0][i]) / (2.0 * kToSideExact * h_),
                 rise = 0.5 * (beyond_[0][i] + beyond_[1][i]) - near_.level[i];
    if (!face_[i] || slope < kSteep) continue;
    const double edge = lo_[i] + kBeyondExact * h_ - rise / slope;
    put(i, std::clamp(edge, lo_[i] - kLevel * h_, lo_[i] + kLevel * h_), slope, kToSideExact, ways);
  }
}

void EdgeFinder::locate_sampled(double sign, double reach, Ways& ways) {
  beside(sign, kBent + kBeyond, kToSide);
  for (int k = 0; k < 3; ++k) beyond(sign, kBent + k * kBeyond, beyond_[k]);
  for (int i = 0; i < near_.n; ++i) {
    const double slope = (beyond_[1][i] - beyond_[0][i]) / (kBeyond * h_);
    if (!face_[i] || slope < kSteep) continue;
    const double begin = std::max(0.0, lo_[i] - kLevel * h_), rise = beyond_[0][i] - near_.level[i],
                 further = (beyond_[2][i] - beyond_[1][i]) / (kBeyond * h_), edge = lo_[i] + kBent * h_ - rise / slope;
    const bool straight = std::abs(further - slope) <= kStraight * slope;
    if (!straight || edge <= reach) put(i, straight ? std::max(begin, edge) : begin, slope, kToSide, ways);
  }
}

void EdgeFinder::put(int i, double way, double slope, double to_side, Ways& ways) const {
  const int of = rises_[i];
  if (!(way > kLevel * h_)) return;  // on the edge already
  ways.way[of] = way, ways.along[of] = slope;
  ways.across[of] = (left_[i] - right_[i]) / (2.0 * to_side * h_);
}

void EdgeFinder::distances(const CubeSide& side, const Search& s, const Numbers& t, Numbers& d) {
  places_along(side.pose, s.x, s.e, t, s.n, local_);
  side.solid->distances({local_[0].data(), local_[1].data(), local_[2].data(), s.n}, d.data());
}

}  // namespace brim
