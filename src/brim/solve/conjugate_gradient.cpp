#include "brim/solve/conjugate_gradient.h"

#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"
#include "brim/core/simd.h"
#include "brim/core/stop.h"

namespace brim {

namespace {

/// Unknowns of a chunk at most.
constexpr std::size_t kChunk = 4096;
/// Iterations after which directions are made as Polak and Ribière do: a preconditioner that single precision has made
/// unsymmetric still leads somewhere (Golub and Ye 1999).
constexpr int kFlexible = 50;
/// Chunks worked on by one thread at a time: of small bodies there are many.
constexpr std::size_t kGrain = 1;

/// In lanes, whose order of adding does not depend on the machine.
double dot_of(std::span<const double> a, std::span<const double> b, std::size_t begin, std::size_t end) {
  constexpr std::size_t kStep = 4 * kLanes;
  Lanes sum[4] = {};
  std::size_t i = begin;
  for (; i + kStep <= end; i += kStep)
    for (std::size_t k = 0; k < 4; ++k)
      sum[k] += load_lanes(a.data() + i + k * kLanes) * load_lanes(b.data() + i + k * kLanes);
  const Lanes all = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  double s = (all[0] + all[1]) + (all[2] + all[3]);
  for (; i < end; ++i) s += a[i] * b[i];
  return s;
}

}  // namespace

void ConjugateGradient::find_chunks(const LinearSystem& system, std::size_t n) {
  const std::size_t whole[] = {0, n};
  const std::int32_t one[] = {0};
  const auto first = system.island.empty() ? std::span<const std::size_t>(whole) : system.first;
  const auto island = system.island.empty() ? std::span<const std::int32_t>(one) : system.island;
  std::int32_t islands = 0;
  chunks_.clear();
  auto idle = system.idle.begin();
  for (std::size_t s = 0; s < island.size(); ++s) {
    islands = std::max(islands, island[s] + 1);
    for (std::size_t begin = first[s]; begin < first[s + 1];) {
      while (idle != system.idle.end() && (*idle)[1] <= begin) ++idle;
      if (idle != system.idle.end() && (*idle)[0] <= begin) {
        begin = std::min(first[s + 1], (*idle)[1]);
        continue;
      }
      const std::size_t end = idle == system.idle.end() ? first[s + 1] : std::min(first[s + 1], (*idle)[0]);
      Chunk* last = chunks_.empty() ? nullptr : &chunks_.back();
      if (last == nullptr || last->island != island[s] || last->end != begin || last->end - last->begin >= kChunk) {
        chunks_.push_back({begin, begin, island[s]});
        last = &chunks_.back();
      }
      begin = last->end = std::min(end, last->begin + kChunk);
    }
  }
  islands_.assign(static_cast<std::size_t>(islands), Island{.open = true});
  solved_.assign(system.island.size(), 0);
  part_.resize(chunks_.size()), sum_.resize(islands_.size());
}

void ConjugateGradient::dot(std::span<const double> a, std::span<const double> b) {
  parallel_for(
      chunks_.size(),
      [&](std::size_t c) {
        const Chunk& k = chunks_[c];
        part_[c] = islands_[k.island].open ? dot_of(a, b, k.begin, k.end) : 0.0;
      },
      kGrain);
  std::fill(sum_.begin(), sum_.end(), 0.0);
  for (std::size_t c = 0; c < chunks_.size(); ++c) sum_[chunks_[c].island] += part_[c];
}

template <class F>
void ConjugateGradient::for_open(const F& f) const {
  parallel_for(
      chunks_.size(),
      [&](std::size_t c) {
        const Chunk& k = chunks_[c];
        const Island& island = islands_[k.island];
        if (!island.open) return;
        for (std::size_t i = k.begin; i < k.end; ++i) f(island, i);
      },
      kGrain);
}

bool ConjugateGradient::close(const LinearSystem& system) {
  bool any = false, open = false;
  for (Island& island : islands_) {
    const bool done = island.stuck || !(island.rz > island.goal);
    any = any || (island.open && done);
    island.open = island.open && !done;
    open = open || island.open;
  }
  if (!any) return open;
  for (std::size_t s = 0; s < system.island.size(); ++s) solved_[s] = !islands_[system.island[s]].open;
  for (const Chunk& k : chunks_)
    if (!islands_[k.island].open) std::fill(p_.data() + k.begin, p_.data() + k.end, 0.0);
  return open;
}

SolveReport ConjugateGradient::solve(const LinearSystem& system, std::span<const double> b, double tolerance,
                                     int max_iterations, std::span<double> x, std::vector<double>& scale) {
  const std::size_t n = b.size();
  r_.resize(n), z_.resize(n), p_.resize(n), y_.resize(n);
  find_chunks(system, n);
  const std::size_t count = islands_.size();
  const auto sharpness = [&](std::size_t k) { return system.sharpness.empty() ? 1.0 : system.sharpness[k]; };
  SolveReport report;

  system.filter(x);
  const bool warm = std::any_of(x.begin(), x.end(), [](double xi) { return xi != 0.0; });
  const bool known = warm && scale.size() == count;
  if (!known) {
    std::copy(b.begin(), b.end(), r_.begin());
    system.filter(r_);
    system.precondition(r_, z_);
    dot(r_, z_);
    scale = sum_;
  }
  report.finite = std::all_of(scale.begin(), scale.end(), [](double s) { return std::isfinite(s); });
  if (!report.finite) return report;

  // r = S (b − A x)
  if (warm) {
    system.apply(x, y_);
    for (std::size_t i = 0; i < n; ++i) r_[i] = b[i] - y_[i];
    system.filter(r_);
    system.precondition(r_, z_);
    dot(r_, z_);
  }
  system.filter(z_);
  std::copy(z_.begin(), z_.end(), p_.begin());
  for (std::size_t k = 0; k < count; ++k) {
    Island& island = islands_[k];
    island.rz = sum_[k];
    const double mine = tolerance * sharpness(k);
    island.goal = std::max(mine * mine * scale[k], system.negligible.empty() ? 0.0 : system.negligible[k]);
    island.stuck = scale[k] <= 0.0;
  }
  // What nothing acts on does not change its velocity.
  for (const Chunk& k : chunks_)
    for (std::size_t i = k.begin; i < k.end && islands_[k.island].stuck; ++i) x[i] = r_[i] = 0.0;
  for (Island& island : islands_)
    if (island.stuck) island.rz = 0.0;
  const auto all_finite = [&] {
    for (std::size_t k = 0; k < count; ++k)
      report.finite = report.finite && (!islands_[k].open || std::isfinite(sum_[k]));
    if (!report.finite) solved_.clear();
    return report.finite;
  };
  while (close(system) && report.iterations < max_iterations) {
    check_stop();
    system.apply(p_, y_);
    system.filter(y_);
    dot(p_, y_);
    if (!all_finite()) return report;
    for (std::size_t k = 0; k < count; ++k) {
      Island& island = islands_[k];
      island.stuck = island.open && !(sum_[k] > 0.0);
      island.step = island.open && !island.stuck ? island.rz / sum_[k] : 0.0;
    }
    for_open([&](const Island& island, std::size_t i) {
      x[i] += island.step * p_[i];
      r_[i] -= island.step * y_[i];
    });
    system.precondition(r_, z_);
    system.filter(z_);
    ++report.iterations;
    const bool flexible = report.iterations >= kFlexible;
    if (flexible) {
      dot(y_, z_);
      for (std::size_t k = 0; k < count; ++k) islands_[k].ratio = -islands_[k].step * sum_[k] / islands_[k].rz;
    }
    dot(r_, z_);
    if (!all_finite()) return report;
    for (std::size_t k = 0; k < count; ++k) {
      Island& island = islands_[k];
      if (!island.open || island.stuck) continue;
      if (!flexible) island.ratio = sum_[k] / island.rz;
      island.rz = sum_[k];
    }
    for_open([&](const Island& island, std::size_t i) { p_[i] = z_[i] + island.ratio * p_[i]; });
  }
  solved_.clear();
  report.converged = true;
  for (std::size_t k = 0; k < count; ++k) {
    if (scale[k] > 0.0)
      report.residual = std::max(report.residual, std::sqrt(std::max(0.0, islands_[k].rz) / scale[k]) / sharpness(k));
    report.converged = report.converged && islands_[k].rz <= islands_[k].goal;
  }
  return report;
}

}  // namespace brim
