#include "brim/body/particle_fluid/fluid_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "brim/core/parallel.h"

namespace brim {

namespace {

constexpr std::size_t kGrain = 128;
/// Lengths below are in spacings.
constexpr double kSoft = 0.25;  ///< u bends to zero over this distance to either side of the surface
constexpr double kTrue = 0.7;   ///< u is the distance up to here
constexpr double kBarrierReach = 0.5;
constexpr double kBarrier = 2.1;          ///< a lone particle, a third full, is full at 0.1 spacings
constexpr double kBending = 0.5;          ///< share of a surface's bend that images lose their weight by
constexpr double kMostWeight = 3.0;       ///< of images behind surfaces that are bent towards the fluid
constexpr std::size_t kMostSurfaces = 3;  ///< of a particle that have images of images

}  // namespace

double FluidImages::offset(double d, double& slope) const {
  const double t = d / spacing_;
  // Two particles at the reach and at half a spacing are a support apart.
  const double support = kernel_.support() / spacing_, end = 0.5 * support * support;
  const double bend = (end - kReach) / ((kReach - kTrue) * (kReach - kTrue));
  if (t <= -kSoft) return slope = 0.0;
  if (t < kSoft) {
    slope = (t + kSoft) / (2.0 * kSoft);
    return spacing_ * (t + kSoft) * (t + kSoft) / (4.0 * kSoft);
  }
  if (t <= kTrue) {
    slope = 1.0;
    return d;
  }
  slope = 1.0 + 2.0 * bend * (t - kTrue);
  return spacing_ * (t + bend * (t - kTrue) * (t - kTrue));
}

double FluidImages::barrier(double d, double& slope) const {
  const double u = kBarrierReach - d / spacing_;
  if (!(u > 0.0)) return slope = 0.0;
  slope = -2.0 * kBarrier * u / spacing_;
  return kBarrier * u * u;
}

void FluidImages::take(std::span<const Seen> seen, std::span<const std::int32_t> slot) {
  const std::size_t n = seen.size();
  slot_of_.resize(n), part_.resize(n), n_.resize(n), sorted_.resize(n);
  u_.resize(n), u_slope_.resize(n), barrier_.resize(n), barrier_slope_.resize(n);
  weight_.resize(n), weight_slope_.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Seen& s = seen[k];
    slot_of_[k] = slot[s.element], part_[k] = s.part, n_[k] = s.n;
    u_[k] = offset(s.distance, u_slope_[k]);
    barrier_[k] = barrier(s.distance, barrier_slope_[k]);
    const double d = std::max(0.0, s.distance), weight = 1.0 - kBending * d * s.bend;
    weight_[k] = std::clamp(weight, 0.0, kMostWeight);
    // As of a ball, L = 2/(R + d).
    weight_slope_[k] = weight == weight_[k] && s.distance > 0.0 ? -kBending * s.bend * (1.0 - 0.5 * d * s.bend) : 0.0;
  }
  std::iota(sorted_.begin(), sorted_.end(), 0);
  std::stable_sort(sorted_.begin(), sorted_.end(),
                   [&](std::int32_t a, std::int32_t b) { return slot_of_[a] < slot_of_[b]; });
  seeing_.clear(), first_.clear();
  place_.assign(slot.size(), -1);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t s = slot_of_[sorted_[i]];
    if (i > 0 && s == slot_of_[sorted_[i - 1]]) continue;
    place_[s] = static_cast<std::int32_t>(seeing_.size());
    seeing_.push_back(s), first_.push_back(i);
  }
  first_.push_back(n);
}

double FluidImages::add_images(std::size_t i, std::size_t j, std::int32_t pair, double distance2,
                               std::span<std::vector<Entry>> rows, double& fill) const {
  const auto mine = contacts_of(i), theirs = contacts_of(j);
  struct Common {  ///< a surface that both see
    std::size_t row;
    std::int32_t k, other;
    double out = 0.0, in = 0.0;
  };
  std::array<Common, kMostSurfaces> common;
  std::size_t count = 0;
  for (std::size_t m = 0; m < mine.size(); ++m)
    for (const std::int32_t o : theirs)
      if (part_[o] == part_[mine[m]] && count < kMostSurfaces) common[count++] = {m, mine[m], o};
  const double H2 = kernel_.support() * kernel_.support();
  double along = 0.0;
  for (unsigned set = 1; set < 1u << count; ++set) {
    const auto holds = [set](std::size_t c) { return (set >> c & 1u) != 0; };
    double r2 = distance2, weight = 1.0;
    for (std::size_t c = 0; c < count; ++c) {
      if (!holds(c)) continue;
      const auto& [row, k, o, out, in] = common[c];
      r2 += 4.0 * (u_[k] * u_[o]);
      weight *= 0.5 * (weight_[k] + weight_[o]);
      for (std::size_t e = 0; e < c; ++e)
        if (holds(e))
          weight *= std::max(
              0.0, 1.0 - 0.5 * (std::abs(n_[k].dot(n_[common[e].k])) + std::abs(n_[o].dot(n_[common[e].other]))));
    }
    if (r2 >= H2 || weight == 0.0) continue;
    const double r = std::sqrt(r2), slope = weight * volume_ * kernel_.slope_over_r(r);
    const double value = weight * volume_ * kernel_.value(r);
    fill += value, along += slope;
    for (std::size_t c = 0; c < count; ++c) {
      if (!holds(c)) continue;
      auto& [row, k, o, out, in] = common[c];
      const double share = value / (weight_[k] + weight_[o]);  // of the weight's change
      out += 2.0 * slope * u_[o] * u_slope_[k] + share * weight_slope_[k];
      in += 2.0 * slope * u_[k] * u_slope_[o] + share * weight_slope_[o];
    }
  }
  for (std::size_t c = 0; c < count; ++c)
    if (common[c].out != 0.0 || common[c].in != 0.0)
      rows[common[c].row].push_back(
          {common[c].other, pair, static_cast<float>(common[c].out), static_cast<float>(common[c].in)});
  return along;
}

void FluidImages::build(std::span<const Seen> seen, std::span<const std::int32_t> slot, const ParticleCells& cells,
                        FluidPairs& pairs, std::span<double> fill) {
  take(seen, slot);
  pairs.release();
  const auto x = cells.positions();
  pieces_.resize((seeing_.size() + kGrain - 1) / kGrain);
  parallel_for(pieces_.size(), [&](std::size_t b) {
    Piece& piece = pieces_[b];
    piece.entries.clear(), piece.length.clear(), piece.stretch.clear();
    std::vector<std::vector<Entry>> rows;
    for (std::size_t p = b * kGrain; p < std::min(seeing_.size(), (b + 1) * kGrain); ++p) {
      const auto i = static_cast<std::size_t>(seeing_[p]);
      const auto mine = contacts_of(i);
      rows.assign(mine.size(), {});
      double added = 0.0;
      add_images(i, i, -1, 0.0, rows, added);
      std::int32_t pair = -1;
      pairs.for_neighbours(i, [&](std::int32_t n, const FluidPairs::Vec4&) {
        const auto j = static_cast<std::size_t>(n);
        ++pair;
        if (place_[j] < 0) return;
        const double r2 = (x[i] - x[j]).squaredNorm();
        const double along = add_images(i, j, pair, r2, rows, added);
        const double own = volume_ * kernel_.slope_over_r(std::sqrt(r2));
        if (along != 0.0 && own < 0.0) piece.stretch.push_back({i, pair, static_cast<float>(1.0 + along / own)});
      });
      for (std::size_t m = 0; m < mine.size(); ++m) {
        added += barrier_[mine[m]];
        piece.length.push_back(static_cast<std::int32_t>(rows[m].size()));
        piece.entries.insert(piece.entries.end(), rows[m].begin(), rows[m].end());
      }
      fill[i] += added;
    }
  });
  entries_.clear(), first_entry_.assign(seen.size(), 0), length_.assign(seen.size(), 0);
  std::size_t contact = 0;
  for (const Piece& piece : pieces_) {
    std::size_t at = entries_.size();
    entries_.insert(entries_.end(), piece.entries.begin(), piece.entries.end());
    for (const std::int32_t length : piece.length) {
      const std::int32_t k = sorted_[contact++];
      first_entry_[k] = at, length_[k] = static_cast<std::size_t>(length);
      at += static_cast<std::size_t>(length);
    }
    for (const Stretch& s : piece.stretch) pairs.stretch(s.particle, s.pair, s.factor);
  }
}

double FluidImages::rate_of(std::size_t slot, std::span<const double> closing) const {
  double rate = 0.0;
  for (const std::int32_t k : contacts_of(slot)) {
    double own = barrier_slope_[k];
    for (const Entry& e : row(static_cast<std::size_t>(k))) own += e.out, rate += e.in * closing[e.other];
    rate += own * closing[k];
  }
  return rate;
}

void FluidImages::add_rates(std::span<const double> closing, std::span<float> rate) const {
  parallel_blocks(seeing_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const auto i = static_cast<std::size_t>(seeing_[p]);
      rate[i] += static_cast<float>(rate_of(i, closing));
    }
  });
}

void FluidImages::press(std::span<const float> p, std::span<double> push) const {
  parallel_blocks(push.size(), 4 * kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const double own = p[slot_of_[k]];
      double sum = barrier_slope_[k] * own;
      for (const Entry& e : row(k)) sum += e.out * (own + double{p[slot_of_[e.other]]});
      push[k] = -sum;
    }
  });
}

double FluidImages::stiffness(std::size_t k, std::span<const float> weight) const {
  double sum = 0.0, own = barrier_slope_[k];
  for (const Entry& e : row(k)) {
    own += e.out;
    if (e.pair >= 0)
      sum += double{weight[slot_of_[e.other]]} * e.out * e.out;
    else
      own += e.out;  // its own image: both sides are the particle itself
  }
  return sum + double{weight[slot_of_[k]]} * own * own;
}

}  // namespace brim
