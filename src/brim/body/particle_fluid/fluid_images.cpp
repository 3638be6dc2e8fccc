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

void FluidImages::build(std::span<const Seen> seen, std::span<const std::int32_t> slot, const ParticleCells& cells,
                        FluidPairs& pairs, std::span<double> fill) {
  const std::size_t n = seen.size();
  slot_of_.resize(n), u_.resize(n), u_slope_.resize(n), barrier_slope_.resize(n), weight_.resize(n);
  weight_slope_.resize(n), n_.resize(n);
  part_.resize(n), sorted_.resize(n), first_entry_.assign(n, 0), length_.assign(n, 0);
  pairs.release();
  std::vector<double> barrier_fill(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Seen& s = seen[k];
    slot_of_[k] = slot[s.element], part_[k] = s.part, n_[k] = s.n;
    u_[k] = offset(s.distance, u_slope_[k]);
    barrier_fill[k] = barrier(s.distance, barrier_slope_[k]);
    const double d = std::max(0.0, s.distance), weight = 1.0 - kBending * d * s.bend;
    weight_[k] = std::clamp(weight, 0.0, kMostWeight);
    // As of a ball, L = 2/(R + d).
    weight_slope_[k] = weight == weight_[k] && s.distance > 0.0 ? -kBending * s.bend * (1.0 - 0.5 * d * s.bend) : 0.0;
  }
  std::iota(sorted_.begin(), sorted_.end(), 0);
  std::stable_sort(sorted_.begin(), sorted_.end(),
                   [&](std::int32_t a, std::int32_t b) { return slot_of_[a] < slot_of_[b]; });
  seeing_.clear(), first_.clear();
  place_.assign(cells.size(), -1);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t s = slot_of_[sorted_[i]];
    if (i > 0 && s == slot_of_[sorted_[i - 1]]) continue;
    place_[s] = static_cast<std::int32_t>(seeing_.size());
    seeing_.push_back(s), first_.push_back(i);
  }
  first_.push_back(n);

  const auto x = cells.positions();
  const double H2 = kernel_.support() * kernel_.support();
  pieces_.resize((seeing_.size() + kGrain - 1) / kGrain);
  parallel_for(pieces_.size(), [&](std::size_t b) {
    Piece& piece = pieces_[b];
    piece.entries.clear(), piece.length.clear(), piece.stretch.clear(), piece.stretched.clear();
    std::vector<std::vector<Entry>> rows;
    for (std::size_t p = b * kGrain; p < std::min(seeing_.size(), (b + 1) * kGrain); ++p) {
      const auto i = static_cast<std::size_t>(seeing_[p]);
      const auto mine = contacts_of(i);
      rows.assign(mine.size(), {});
      double added = 0.0;
      // Images of particle j, over all sets of surfaces that both see.
      const auto look = [&](std::size_t j, std::int32_t pair) {
        const auto theirs = contacts_of(j);
        if (theirs.empty()) return;
        struct Common {
          std::size_t mine;
          std::int32_t k, other;
          double reach2;  ///< 4 u u
        };
        std::array<Common, kMostSurfaces> common;
        std::size_t count = 0;
        for (std::size_t m = 0; m < mine.size() && count < kMostSurfaces; ++m)
          for (const std::int32_t o : theirs)
            if (part_[o] == part_[mine[m]] && count < kMostSurfaces)
              common[count++] = {m, mine[m], o, 4.0 * (u_[mine[m]] * u_[o])};
        const double r2 = (x[i] - x[j]).squaredNorm();
        double along = 0.0;
        std::array<double, kMostSurfaces> out{}, in{};
        for (unsigned set = 1; set < 1u << count; ++set) {
          double q2 = r2, weight = 1.0;
          for (std::size_t c = 0; c < count; ++c) {
            if ((set >> c & 1u) == 0) continue;
            q2 += common[c].reach2;
            weight *= 0.5 * (weight_[common[c].k] + weight_[common[c].other]);
            for (std::size_t e = 0; e < c; ++e)
              if ((set >> e & 1u) != 0)
                weight *= std::max(0.0, 1.0 - 0.5 * (std::abs(n_[common[c].k].dot(n_[common[e].k])) +
                                                     std::abs(n_[common[c].other].dot(n_[common[e].other]))));
          }
          if (q2 >= H2 || weight == 0.0) continue;
          const double q = std::sqrt(q2), slope = weight * volume_ * kernel_.slope_over_r(q);
          const double value = weight * volume_ * kernel_.value(q);
          added += value;
          along += slope;
          for (std::size_t c = 0; c < count; ++c)
            if ((set >> c & 1u) != 0) {
              const std::int32_t k = common[c].k, o = common[c].other;
              const double share = value / (weight_[k] + weight_[o]);  // of the weight's change
              out[c] += 2.0 * slope * u_[o] * u_slope_[k] + share * weight_slope_[k];
              in[c] += 2.0 * slope * u_[k] * u_slope_[o] + share * weight_slope_[o];
            }
        }
        for (std::size_t c = 0; c < count; ++c)
          if (out[c] != 0.0 || in[c] != 0.0)
            rows[common[c].mine].push_back(
                {common[c].other, pair, static_cast<float>(out[c]), static_cast<float>(in[c])});
        if (along != 0.0 && pair >= 0) {
          // g_ij stands for x_ij times the slope of the pair itself.
          const double own = volume_ * kernel_.slope_over_r(std::sqrt(r2));
          if (own < 0.0)
            piece.stretch.emplace_back(pair, static_cast<float>(1.0 + along / own)),
                piece.stretched.push_back(static_cast<std::int32_t>(i));
        }
      };
      look(i, -1);
      std::int32_t pair = 0;
      pairs.for_neighbours(i,
                           [&](std::int32_t j, const FluidPairs::Vec4&) { look(static_cast<std::size_t>(j), pair++); });
      for (std::size_t m = 0; m < mine.size(); ++m) {
        added += barrier_fill[mine[m]];
        piece.length.push_back(static_cast<std::int32_t>(rows[m].size()));
        piece.entries.insert(piece.entries.end(), rows[m].begin(), rows[m].end());
      }
      fill[i] += added;
    }
  });
  entries_.clear();
  std::size_t contact = 0;
  for (const Piece& piece : pieces_) {
    std::size_t at = entries_.size();
    entries_.insert(entries_.end(), piece.entries.begin(), piece.entries.end());
    for (const std::int32_t length : piece.length) {
      const std::int32_t k = sorted_[contact++];
      first_entry_[k] = at, length_[k] = static_cast<std::size_t>(length);
      at += static_cast<std::size_t>(length);
    }
    for (std::size_t e = 0; e < piece.stretch.size(); ++e)
      pairs.stretch(static_cast<std::size_t>(piece.stretched[e]), piece.stretch[e].first, piece.stretch[e].second);
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
      own += e.out;
  }
  return sum + double{weight[slot_of_[k]]} * own * own;
}

}  // namespace brim
