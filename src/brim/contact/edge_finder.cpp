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
/// Part of it that may be lost in the round beginning of a rise; [voxels] error of an edge by rough distances.
constexpr double kRounding = 0.1, kRough = 0.2, kRoughLevel = 0.06;
/// Bisections of the distance to an edge: 2^-6 of a voxel; half as many by exact distances.
constexpr int kHalvings = 6;
/// [voxels] A sampled distance bends around an edge over one spacing, half a voxel: beyond kBent three points, kBeyond
/// apart, locate the edge if their slopes differ by at most the share kStraight.
constexpr double kBent = 0.6, kBeyond = 0.3, kStraight = 0.12;
/// [voxels] beyond the reach of a search, to where a rise is steep if an edge is within reach.
constexpr double kFurther = 0.9;
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

void EdgeFinder::gaps(const Search& s, const Numbers& t, Numbers& gap, bool roughly) {
  distances(a_, s, t, roughly, gap);
  distances(b_, s, t, roughly, other_);
  for (int i = 0; i < s.n; ++i) gap[i] += other_[i];
}

void EdgeFinder::gaps(const Search& s, double t, Numbers& gap, bool roughly) {
  std::fill_n(t_.begin(), s.n, t);
  gaps(s, t_, gap, roughly);
}

double EdgeFinder::level_of(bool roughly) const { return (roughly && !exact_ ? kRoughLevel : kLevel) * h_; }

void EdgeFinder::glimpse(const Search& all, double sign, double reach, Ways& ways) {
  take_rising(all, sign, reach, true, ways);
  if (near_.n == 0) return;
  // Few of the gaps that rise do so beyond an edge: one of the two parts of the way is steep there.
  const double level = level_of(true), middle = 0.5 * reach, further = kFurther * h_;
  gaps(near_, sign * middle, left_, true), gaps(near_, sign * (reach + further), right_, true);
  for (int i = 0; i < near_.n; ++i) {
    (left_[i] <= near_.level[i] + level ? lo_ : hi_)[i] = middle;
    along_[i] = std::max((rise_[i] - left_[i]) / middle, (right_[i] - rise_[i]) / further);
  }
  keep([&](int i) { return along_[i] >= kSteep - kRounding; });
  halve(sign, kHalvings / 2, true);
  if (!exact_) {
    beyond(sign, kBent, left_, true), beyond(sign, kBent + kBeyond, right_, true);
    keep([&](int i) { return right_[i] - left_[i] >= (kSteep - kRounding) * kBeyond * h_; });
    for (int i = 0; i < near_.n; ++i)
      lo_[i] = std::max(0.0, lo_[i] - kRough * h_), hi_[i] = std::min(reach, hi_[i] + kRough * h_);
    halve(sign, kHalvings - 2, false);
  }
  locate(sign, reach);
  drop_ridges(sign);
  look_across(sign);
  put(ways);
}

void EdgeFinder::find(const Search& all, double sign, double reach, Ways& ways) {
  take_rising(all, sign, reach, false, ways);
  if (near_.n == 0) return;
  gaps(near_, -0.5 * sign * h_, gap_);
  keep([&](int i) { return std::abs(gap_[i] - near_.level[i]) <= kLevel * h_; });
  halve(sign, exact_ ? kHalvings / 2 : kHalvings, false);
  drop_ridges(sign);
  locate(sign, reach);
  put(ways);
}

void EdgeFinder::take_rising(const Search& all, double sign, double reach, bool roughly, Ways& ways) {
  for (Numbers* w : {&ways.way, &ways.along, &ways.across}) std::fill_n(w->begin(), all.n, 0.0);
  gaps(all, sign * reach, gap_, roughly);
  near_.n = 0;
  for (int i = 0; i < all.n; ++i)
    if (gap_[i] > all.level[i] + kLevel * h_) of_[near_.n] = i, rise_[near_.n] = gap_[i], near_.take(all, i);
  std::fill_n(lo_.begin(), near_.n, 0.0), std::fill_n(hi_.begin(), near_.n, reach);
}

template <class Kept>
void EdgeFinder::keep(const Kept& kept) {
  const int n = near_.n;
  near_.n = 0;
  for (int i = 0; i < n; ++i) {
    if (!kept(i)) continue;
    const int k = near_.n;
    of_[k] = of_[i];
    for (Numbers* v : {&rise_, &lo_, &hi_, &way_, &along_, &across_}) (*v)[k] = (*v)[i];
    near_.take(near_, i);
  }
}

void EdgeFinder::halve(double sign, int times, bool roughly) {
  const double level = level_of(roughly);
  for (int k = 0; k < times; ++k) {
    for (int i = 0; i < near_.n; ++i) t_[i] = 0.5 * (sign * (lo_[i] + hi_[i]));
    gaps(near_, t_, gap_, roughly);
    for (int i = 0; i < near_.n; ++i) (gap_[i] <= near_.level[i] + level ? lo_ : hi_)[i] = 0.5 * (lo_[i] + hi_[i]);
  }
}

void EdgeFinder::drop_ridges(double sign) {
  for (int i = 0; i < near_.n; ++i) t_[i] = 0.5 * sign * lo_[i];
  gaps(near_, t_, gap_);
  const double dip = (exact_ ? kLevel : kDip) * h_;  // sampled distances dip beside an edge
  keep([&](int i) { return gap_[i] >= near_.level[i] - dip; });
}

void EdgeFinder::beyond(double sign, double distance, Numbers& gap, bool roughly) {
  for (int i = 0; i < near_.n; ++i) t_[i] = sign * (lo_[i] + distance * h_);
  gaps(near_, t_, gap, roughly);
}

void EdgeFinder::locate(double sign, double reach) {
  exact_ ? locate_exact(sign) : locate_sampled(sign, reach);
  keep([&](int i) { return way_[i] > kLevel * h_; });
}

void EdgeFinder::locate_exact(double sign) {
  beyond(sign, kBeyondExact - kToSideExact, beyond_[0]), beyond(sign, kBeyondExact + kToSideExact, beyond_[1]);
  for (int i = 0; i < near_.n; ++i) {
    const double slope = (beyond_[1][i] - beyond_[0][i]) / (2.0 * kToSideExact * h_),
                 rise = 0.5 * (beyond_[0][i] + beyond_[1][i]) - near_.level[i];
    const double edge = lo_[i] + kBeyondExact * h_ - rise / slope;
    along_[i] = slope;
    way_[i] = slope < kSteep ? 0.0 : std::clamp(edge, lo_[i] - kLevel * h_, hi_[i] + kLevel * h_);
  }
}

void EdgeFinder::locate_sampled(double sign, double reach) {
  for (int k = 0; k < 3; ++k) beyond(sign, kBent + k * kBeyond, beyond_[k]);
  for (int i = 0; i < near_.n; ++i) {
    const double slope = (beyond_[1][i] - beyond_[0][i]) / (kBeyond * h_);
    const double begin = std::max(0.0, lo_[i] - kLevel * h_), rise = beyond_[0][i] - near_.level[i],
                 further = (beyond_[2][i] - beyond_[1][i]) / (kBeyond * h_), edge = lo_[i] + kBent * h_ - rise / slope;
    const bool straight = std::abs(further - slope) <= kStraight * slope;
    along_[i] = slope;
    way_[i] = slope < kSteep || (straight && edge > reach) ? 0.0 : straight ? std::max(begin, edge) : begin;
  }
}

void EdgeFinder::look_across(double sign) {
  const double distance = exact_ ? kBeyondExact : kBent + kBeyond, to_side = (exact_ ? kToSideExact : kToSide) * h_;
  for (const double side : {to_side, -to_side}) {
    near_.go_across(side);
    beyond(sign, distance, side > 0.0 ? left_ : right_);
    near_.go_across(-side);
  }
  for (int i = 0; i < near_.n; ++i) across_[i] = (left_[i] - right_[i]) / (2.0 * to_side);
}

void EdgeFinder::put(Ways& ways) const {
  for (int i = 0; i < near_.n; ++i)
    ways.way[of_[i]] = way_[i], ways.along[of_[i]] = along_[i], ways.across[of_[i]] = across_[i];
}

void EdgeFinder::distances(const CubeSide& side, const Search& s, const Numbers& t, bool roughly, Numbers& d) {
  places_along(side.pose, s.x, s.e, t, s.n, local_);
  if (!roughly || side.solid->slack() == 0.0)
    return side.solid->distances({local_[0].data(), local_[1].data(), local_[2].data(), s.n}, d.data());
  for (int i = 0; i < s.n; ++i) d[i] = side.solid->rough_distance({local_[0][i], local_[1][i], local_[2][i]});
}

}  // namespace brim
