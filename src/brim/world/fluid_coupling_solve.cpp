#include <algorithm>
#include <cmath>

#include "brim/core/parallel.h"
#include "brim/core/profile.h"
#include "brim/core/simd.h"
#include "brim/core/stop.h"
#include "brim/world/fluid_coupling.h"

/// Volume conservation of cells for the velocities of fluids and of solids in them.
namespace brim {

namespace {

/// Remaining flow of a cell after a solve, relative to the largest before; the same for a direction of the outer solve,
/// whose pressure is followed from one to the next.
constexpr double kFlowTolerance = 1e-6, kFlowOfDirection = 1e-3;
/// The same when a whole system is relieved, of which only a millionth may act.
constexpr double kSharp = 1e-11;
/// The same relative to the flow through a face: for kept velocities, and rounding level.
constexpr double kKept = 1e-9, kFlowRounding = 1e-15;
constexpr int kMostIterations = 300, kMostRounds = 3;

double largest_of(std::span<const double> x) {
  Lanes most = {};
  std::size_t i = 0;
  for (; i + kLanes <= x.size(); i += kLanes) {
    const Lanes xi = load_lanes(x.data() + i), size = xi > -xi ? xi : -xi;
    most = size > most ? size : most;
  }
  double largest = std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
  for (; i < x.size(); ++i) largest = std::max(largest, std::abs(x[i]));
  return largest;
}

double largest_at(std::span<const std::int32_t> cells, std::span<const double> x) {
  double most = 0.0;
  for (const std::int32_t c : cells) most = std::max(most, std::abs(x[c]));
  return most;
}

double dot_at(std::span<const std::int32_t> cells, std::span<const double> a, std::span<const double> b) {
  return ordered_sum(
      cells.size(),
      [&](std::size_t begin, std::size_t end) {
        double s = 0.0;
        for (std::size_t i = begin; i < end; ++i) s += a[cells[i]] * b[cells[i]];
        return s;
      },
      4096);
}

}  // namespace

void FluidCoupling::add_solid_flow(Side& s, std::span<const double> u, std::span<double> out) {
  at_points_.resize(s.rows.size());
  s.map->apply(slice(u, s.body), at_points_);
  for (std::size_t i = 0; i < s.rows.size(); ++i) {
    const Row& row = s.rows[i];
    const double through = row.area * at_points_[i][row.axis];
    if (row.low >= 0) out[row.low] += through;
    if (row.high >= 0) out[row.high] -= through;
  }
}

void FluidCoupling::push_solids(const Fluid& f, std::span<const double> pressure, std::span<double> impulse) {
  for (const Side& s : f.sides) {
    at_points_.assign(s.rows.size(), Vec3::Zero());
    for (std::size_t i = 0; i < s.rows.size(); ++i) {
      const Row& row = s.rows[i];
      at_points_[i][row.axis] =
          row.area * ((row.low >= 0 ? pressure[row.low] : 0.0) - (row.high >= 0 ? pressure[row.high] : 0.0));
    }
    s.map->apply_transpose(at_points_, slice(impulse, s.body));
  }
}

void FluidCoupling::flow(std::span<const double> u, std::vector<double> Fluid::*out) {
  for (Fluid& f : fluids_) {
    std::vector<double>& to = f.*out;
    f.flow->add_flow(slice(u, f.body), to);
    for (Side& s : f.sides) add_solid_flow(s, u, to);
  }
}

void FluidCoupling::push(const std::vector<double> Fluid::*pressure, std::span<double> impulse) {
  for (Fluid& f : fluids_) {
    f.flow->add_push(f.*pressure, slice(impulse, f.body));
    push_solids(f, f.*pressure, impulse);
  }
}

int FluidCoupling::solve(const Invert& invert, double tolerance) {
  // The fluids' own part is a Poisson equation; each way in which light solids yield costs an iteration, but for their
  // motions as wholes.
  double most = 0.0, rz = 0.0;
  for (Fluid& f : fluids_) {
    std::fill(f.x.begin(), f.x.end(), 0.0);
    most = std::max(most, largest_at(f.flow->wet_cells(), f.r));
  }
  int iterations = 0;
  while (most > tolerance && iterations < kMostIterations) {
    check_stop();
    double next = 0.0;
    invert_flows();
    for (Fluid& f : fluids_) next += dot_at(f.flow->wet_cells(), f.r, f.z);
    if (!(next > 0.0) || !std::isfinite(next)) break;
    const double ratio = iterations > 0 ? next / rz : 0.0;
    rz = next;
    for (Fluid& f : fluids_)
      for (const std::int32_t c : f.flow->wet_cells()) f.p[c] = f.z[c] + ratio * f.p[c];
    apply(invert);
    double curvature = 0.0;
    for (Fluid& f : fluids_) curvature += dot_at(f.flow->wet_cells(), f.p, f.y);
    if (!(curvature > 0.0)) break;
    const double step = rz / curvature;
    most = 0.0;
    for (Fluid& f : fluids_) {
      for (const std::int32_t c : f.flow->wet_cells()) {
        f.x[c] += step * f.p[c];
        f.r[c] -= step * f.y[c];
        most = std::max(most, std::abs(f.r[c]));
      }
    }
    ++iterations;
  }
  profile_count("pressure iterations among solids", iterations);
  return iterations;
}

void FluidCoupling::yield(const Invert& invert, const std::vector<double> Fluid::*pressure) {
  impulse_.assign(first_.back(), 0.0);
  velocity_.resize(first_.back());
  push(pressure, impulse_);
  invert(impulse_, velocity_, Of::All);
}

void FluidCoupling::apply(const Invert& invert) {
  if (!apart_) {
    yield(invert, &Fluid::p);
    flow(velocity_, &Fluid::y);
    return;
  }
  impulse_.resize(first_.back()), velocity_.resize(first_.back());
  for (std::size_t b = 0; b < body_.size(); ++b) {
    if (flows(b)) continue;
    const auto own = slice(std::span<double>(impulse_), static_cast<int>(b));
    std::fill(own.begin(), own.end(), 0.0);
  }
  for (const Fluid& f : fluids_) push_solids(f, f.p, impulse_);
  invert(impulse_, velocity_, Of::Solids);
  for (Fluid& f : fluids_) {
    f.flow->apply_poisson(f.p, f.y);
    for (Side& s : f.sides) add_solid_flow(s, velocity_, f.y);
  }
}

void FluidCoupling::set_untouched(std::span<const std::uint8_t> untouched) {
  yield_known_ = false;
  apart_ = std::ranges::all_of(fluids_, [&](const Fluid& f) { return untouched[f.body] != 0; });
}

double FluidCoupling::find_excess(std::span<const double> u) {
  flow(u, &Fluid::r);
  double most = 0.0;
  for (Fluid& f : fluids_) {
    for (const std::int32_t c : f.flow->wet_cells()) f.r[c] = -f.r[c], most = std::max(most, std::abs(f.r[c]));
  }
  return most;
}

void FluidCoupling::keep_volume(const Invert& invert, std::span<const double> v, std::span<double> delta) {
  std::vector<double> sum(v.size());
  for (int round = 0; round < kMostRounds; ++round) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = v[i] + delta[i];
    const double most = find_excess(sum);
    double fastest = 0.0;
    for (const Fluid& f : fluids_) fastest = std::max(fastest, largest_of(slice(std::span<const double>(sum), f.body)));
    const double goal = kKept * std::pow(fluids_.front().flow->flow_grid().dx, 2) * fastest;
    if (most <= goal || solve(invert, std::max(0.1 * goal, kFlowTolerance * most)) == 0) return;
    yield(invert, &Fluid::x);
    for (std::size_t i = 0; i < delta.size(); ++i) delta[i] += velocity_[i];
    for (Fluid& f : fluids_)
      for (const std::int32_t c : f.flow->wet_cells()) f.pressure[c] += f.x[c];
  }
}

void FluidCoupling::resist(const Invert& invert, std::span<double> r) { resist(invert, kFlowOfDirection, 0.0, r); }

void FluidCoupling::resist(const Invert& invert, double tolerance, double floor, std::span<double> r) {
  // Starts from the last pressure, which hardly changes within a solve; only the difference is computed.
  push(&Fluid::guess, r);
  velocity_.resize(first_.back());
  invert(r, velocity_, Of::All);
  const double most = find_excess(velocity_);
  const double fastest = largest_of(velocity_), area = std::pow(fluids_.front().flow->flow_grid().dx, 2);
  solve(invert, std::max({tolerance * most, floor, kFlowRounding * area * fastest}));
  push(&Fluid::x, r);
  for (Fluid& f : fluids_)
    for (const std::int32_t c : f.flow->wet_cells()) f.guess[c] += f.x[c];
}

void FluidCoupling::relieve(const Invert& invert, std::span<double> r) {
  // Sharp relative to what all pressure holds, however much of it is known already.
  velocity_.resize(first_.back());
  invert(r, velocity_, Of::All);
  const double all = find_excess(velocity_);
  for (Fluid& f : fluids_) f.guess = f.pressure;
  resist(invert, kSharp, kSharp * all, r);
  for (Fluid& f : fluids_) {
    f.pressure.swap(f.guess);
    std::fill(f.guess.begin(), f.guess.end(), 0.0);
  }
}

void FluidCoupling::finish(const Invert& invert, std::span<double> r) {
  relieve(invert, r);
  for (Fluid& f : fluids_) f.flow->take_pressure(f.pressure);
}

}  // namespace brim
