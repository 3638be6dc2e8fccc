#include "brim/math/box_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "brim/core/simd.h"

namespace brim {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float rounded_down(double x) {
  const auto f = static_cast<float>(x);
  return f > x ? std::nextafterf(f, -kInfinity) : f;
}
float rounded_up(double x) { return -rounded_down(-x); }

/// Places begin <= j < end, begin a multiple of kWideLanes, of the boxes of other groups that overlap a box across the
/// axis.
BRIM_WIDE void overlapping_across(const float* const* across, const std::int32_t* group, std::size_t begin,
                                  std::size_t end, const float* of, std::int32_t own, std::vector<std::int32_t>& out) {
  for (std::size_t j = begin; j < end; j += kWideLanes) {
    const WideIds hit = (load_wide(across[0] + j) <= of[1]) & (load_wide(across[1] + j) >= of[0]) &
                        (load_wide(across[2] + j) <= of[3]) & (load_wide(across[3] + j) >= of[2]) &
                        (load_wide(group + j) != own);
    std::int64_t halves[kWideLanes / 2];
    std::memcpy(halves, &hit, sizeof hit);
    if ((halves[0] | halves[1] | halves[2] | halves[3]) == 0) continue;
    for (int l = 0; l < kWideLanes; ++l)
      if (hit[l] != 0) out.push_back(static_cast<std::int32_t>(j) + l);
  }
}

/// Places by which boxes may move up in the order, over their number, before they are sorted anew.
constexpr std::size_t kMoves = 8;

}  // namespace

template <class Less>
void BoxSweep::sort(const Less& less) {
  // Boxes that move little hardly change their order: each is let down from where it was.
  std::size_t moves = kMoves * order_.size();
  for (std::size_t i = 1; i < order_.size(); ++i) {
    const std::int32_t box = order_[i];
    std::size_t to = i;
    for (; to > 0 && less(box, order_[to - 1]); --to) order_[to] = order_[to - 1];
    order_[to] = box;
    if (i - to <= moves) {
      moves -= i - to;
      continue;
    }
    std::sort(order_.begin(), order_.end(), less);
    return;
  }
}

void BoxSweep::build(std::span<const Aabb> boxes, std::span<const std::int32_t> group) {
  boxes_ = boxes;
  Aabb middles;
  for (const Aabb& b : boxes)
    if (b.lo.allFinite() && b.hi.allFinite()) middles.extend(b.center());
  axis_ = 0;
  if (!middles.empty()) middles.extent().maxCoeff(&axis_);
  if (order_.size() != boxes.size()) {
    order_.resize(boxes.size());
    std::iota(order_.begin(), order_.end(), 0);
  }
  const auto key = [&](std::int32_t i) {
    const double lo = boxes[i].lo[axis_];
    return std::isnan(lo) ? std::numeric_limits<double>::infinity() : lo;
  };
  key_.resize(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) key_[i] = key(static_cast<std::int32_t>(i));
  sort([&](std::int32_t a, std::int32_t b) { return key_[a] != key_[b] ? key_[a] < key_[b] : a < b; });
  lo_.resize(boxes.size());
  const std::size_t room = (boxes.size() / kWideLanes + 1) * kWideLanes;
  for (int k = 0; k < 4; ++k) across_[k].assign(room, k % 2 == 0 ? kInfinity : -kInfinity);
  group_.assign(room, 0);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Aabb& b = boxes[order_[i]];
    group_[i] = group.empty() ? order_[i] : group[order_[i]];
    lo_[i] = key_[order_[i]];
    for (int k = 0; k < 2; ++k) {
      const int a = (axis_ + 1 + k) % 3;
      across_[2 * k][i] = rounded_down(b.lo[a]), across_[2 * k + 1][i] = rounded_up(b.hi[a]);
    }
  }
}

void BoxSweep::partners(std::size_t i, std::vector<std::int32_t>& out) const {
  const Aabb& box = boxes_[order_[i]];
  const std::size_t begin = i + 1;
  const std::size_t end =
      std::upper_bound(lo_.begin() + static_cast<std::ptrdiff_t>(begin), lo_.end(), box.hi[axis_]) - lo_.begin();
  if (begin >= end) return;
  const std::size_t before = out.size();
  const float* const across[4] = {across_[0].data(), across_[1].data(), across_[2].data(), across_[3].data()};
  const float of[4] = {across_[0][i], across_[1][i], across_[2][i], across_[3][i]};
  overlapping_across(across, group_.data(), begin / kWideLanes * kWideLanes, end, of, group_[i], out);
  std::size_t kept = before;
  for (std::size_t k = before; k < out.size(); ++k) {
    const auto j = static_cast<std::size_t>(out[k]);
    if (j < begin || j >= end) continue;
    if (boxes_[order_[j]].overlaps(box)) out[kept++] = order_[j];
  }
  out.resize(kept);
}

}  // namespace brim
