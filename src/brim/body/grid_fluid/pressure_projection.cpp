#include "brim/body/grid_fluid/pressure_projection.h"

#include <algorithm>
#include <cmath>

namespace brim {

namespace {
constexpr int kMaxIterations = 200;
/// Flow that is rounding, over the area of a face times the fastest velocity before the pressure.
constexpr double kRounding = 1e-15;
/// Faces or cells that a thread takes at once.
constexpr std::size_t kOfWork = 4096;
}  // namespace

void PressureProjection::prepare(const MacGrid& g, const WetFaces& wet, std::span<const double> mass) {
  grid_ = &g;
  wet_ = &wet;
  push_.clear(), wet_cell_.clear();
  known_.assign(g.cells() + 1, 0.0), change_.assign(g.cells() + 1, 0.0), flow_.assign(g.cells(), 0.0);
  poisson_.reset(g.n);
  GridMatrix& A = poisson_.finest();
  const double area2 = g.dx * g.dx * g.dx * g.dx;
  const auto free_inverse = [&](int f) {
    return wet.kind[f] == WetFaces::Kind::Free ? wet.open[f] * wet.open[f] / mass[f] : 0.0;
  };
  const auto air = static_cast<std::int32_t>(g.cells());
  for (int k = 0; k <= g.n.z(); ++k)
    for (int j = 0; j <= g.n.y(); ++j)
      for (int i = 0; i <= g.n.x(); ++i) {
        const Vec3i at(i, j, k);
        for (int a = 0; a < 3; ++a) {
          const int f = g.face(a, at);
          if (wet.kind[f] != WetFaces::Kind::Free) continue;
          const Vec3i below = at - Vec3i::Unit(a);
          push_.push_back({f, g.inside(below) ? g.cell(below) : air, g.inside(at) ? g.cell(at) : air, 1.0 / mass[f],
                           g.dx * g.dx * wet.open[f]});
        }
        if (!g.inside(at) || !wet.cell[g.cell(at)]) continue;
        const int c = g.cell(at);
        wet_cell_.push_back({c, g.face(0, at)});
        for (int a = 0; a < 3; ++a) {
          const int low = g.face(a, at), high = low + g.face_stride(a);
          const double above = free_inverse(high);
          A.diagonal[c] += area2 * (free_inverse(low) + above);
          const bool last = at[a] + 1 == g.n[a];
          if (!last && wet.cell[c + g.cell_stride(a)]) A.coupling[a][c] = area2 * above;
        }
      }
  poisson_.finish();
}

/// Flow out of each wet cell, [m³/s]; the others are left alone.
void PressureProjection::flow(std::span<const double> u, std::span<double> out) const {
  const MacGrid& g = *grid_;
  const double area = g.dx * g.dx;
  const double* open = wet_->open.data();
  const int sx = g.face_stride(0), sy = g.face_stride(1), sz = g.face_stride(2);
  parallel_for(
      wet_cell_.size(),
      [&](std::size_t n) {
        const auto [c, f] = wet_cell_[n];
        const auto through = [&](int face) { return open[face] * u[face]; };
        out[c] = area * ((through(f + sx) - through(f)) + (through(f + 1 + sy) - through(f + 1)) +
                         (through(f + 2 + sz) - through(f + 2)));
      },
      kOfWork);
}

double PressureProjection::divergence(std::span<const double> u) const {
  std::vector<double> out(grid_->cells(), 0.0);
  flow(u, out);
  double most = 0.0;
  for (const double x : out) most = std::max(most, std::abs(x));
  return most;
}

int PressureProjection::project(std::span<const double> r, double tolerance, std::span<double> z,
                                std::span<double> pressure) {
  const MacGrid& g = *grid_;
  const double area = g.dx * g.dx;
  // What is no unknown of the solve has no pressure, whatever the guess says; nor has the air.
  for (const auto& [c, f] : wet_cell_) known_[c] = pressure[c], change_[c] = 0.0;
  std::fill(z.begin(), z.end(), 0.0);
  std::vector<double> fastest((push_.size() + kOfWork - 1) / kOfWork, 0.0);
  parallel_blocks(push_.size(), kOfWork, [&](std::size_t begin, std::size_t end) {
    double most = 0.0;
    for (std::size_t n = begin; n < end; ++n) {
      const Push& p = push_[n];
      const double free = p.inverse_mass * r[p.face];
      most = std::max(most, std::abs(free));
      z[p.face] = free + p.inverse_mass * p.area * (known_[p.low] - known_[p.high]);
    }
    fastest[begin / kOfWork] = most;
  });
  flow(z, flow_);
  double most = 0.0;
  for (const auto& [c, f] : wet_cell_) flow_[c] = -flow_[c], most = std::max(most, std::abs(flow_[c]));
  const double rounding =
      kRounding * area * (fastest.empty() ? 0.0 : *std::max_element(fastest.begin(), fastest.end()));
  const int iterations =
      poisson_.solve(flow_, std::max(tolerance * most, rounding), kMaxIterations, std::span(change_).first(g.cells()));
  parallel_for(
      push_.size(),
      [&](std::size_t n) {
        const Push& p = push_[n];
        z[p.face] += p.inverse_mass * p.area * (change_[p.low] - change_[p.high]);
      },
      kOfWork);
  std::fill(pressure.begin(), pressure.end(), 0.0);
  for (const auto& [c, f] : wet_cell_) pressure[c] = known_[c] + change_[c];
  return iterations;
}

void PressureProjection::add_push(std::span<const double> pressure, std::span<double> impulse) const {
  const auto air = static_cast<std::int32_t>(grid_->cells());
  const auto at = [&](std::int32_t c) { return c == air || !wet_->cell[c] ? 0.0 : pressure[c]; };
  parallel_for(
      push_.size(),
      [&](std::size_t n) {
        const Push& p = push_[n];
        impulse[p.face] += p.area * (at(p.low) - at(p.high));
      },
      kOfWork);
}

void PressureProjection::divide_by_mass(std::span<const double> r, std::span<double> z) const {
  std::fill(z.begin(), z.end(), 0.0);
  parallel_for(
      push_.size(), [&](std::size_t n) { z[push_[n].face] = push_[n].inverse_mass * r[push_[n].face]; }, kOfWork);
}

Vec3 PressureProjection::wall_impulse(std::span<const double> pressure) const {
  const MacGrid& g = *grid_;
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < g.n.z(); ++k)
    for (int j = 0; j < g.n.y(); ++j)
      for (int i = 0; i < g.n.x(); ++i) {
        const Vec3i at(i, j, k);
        const double p = pressure[g.cell(at)];
        for (int a = 0; a < 3; ++a) {
          const int low = g.face(a, at), high = low + g.face_stride(a);
          if (at[a] == 0 && wet_->kind[low] == WetFaces::Kind::Wall) sum[a] += wet_->open[low] * p;
          if (at[a] + 1 == g.n[a] && wet_->kind[high] == WetFaces::Kind::Wall) sum[a] -= wet_->open[high] * p;
        }
      }
  return g.dx * g.dx * sum;
}

}  // namespace brim
