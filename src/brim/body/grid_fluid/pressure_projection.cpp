#include "brim/body/grid_fluid/pressure_projection.h"

#include <cmath>

namespace brim {

namespace {
constexpr int kMaxIterations = 200;
/// Flow that is rounding, over the area of a face times the fastest velocity before the pressure.
constexpr double kRounding = 1e-15;
}  // namespace

void PressureProjection::prepare(const MacGrid& g, const WetFaces& wet, std::span<const double> mass) {
  grid_ = &g;
  wet_ = &wet;
  inverse_mass_.assign(g.faces(), 0.0);
  for (std::size_t f = 0; f < inverse_mass_.size(); ++f)
    if (wet.kind[f] == WetFaces::Kind::Free) inverse_mass_[f] = 1.0 / mass[f];
  poisson_.reset(g.n);
  GridPoisson::Level& A = poisson_.finest();
  const double area2 = g.dx * g.dx * g.dx * g.dx;
  for_places(g.n, [&](int i, int j, int k) {
    const int c = g.cell(i, j, k);
    if (!wet.cell[c]) return;
    for (int a = 0; a < 3; ++a) {
      const int low = g.face(a, i, j, k), high = low + g.face_stride(a);
      A.diagonal[c] += area2 * (inverse_mass_[low] + inverse_mass_[high]);
      const bool last = Vec3i(i, j, k)[a] + 1 == g.n[a];
      if (!last && wet.cell[c + g.cell_stride(a)]) A.coupling[a][c] = area2 * inverse_mass_[high];
    }
  });
  poisson_.finish();
}

void PressureProjection::flow(std::span<const double> u, std::span<double> out) const {
  const MacGrid& g = *grid_;
  const double area = g.dx * g.dx;
  for_places(g.n, [&](int i, int j, int k) {
    const int c = g.cell(i, j, k);
    double sum = 0.0;
    if (wet_->cell[c])
      for (int a = 0; a < 3; ++a) {
        const int low = g.face(a, i, j, k);
        sum += u[low + g.face_stride(a)] - u[low];
      }
    out[c] = area * sum;
  });
}

double PressureProjection::divergence(std::span<const double> u) const {
  std::vector<double> out(grid_->cells());
  flow(u, out);
  double most = 0.0;
  for (const double x : out) most = std::max(most, std::abs(x));
  return most;
}

void PressureProjection::add_push(std::span<const double> pressure, std::span<double> z) const {
  const MacGrid& g = *grid_;
  const double area = g.dx * g.dx;
  for (int a = 0; a < 3; ++a)
    for_places(g.face_count(a), [&](int i, int j, int k) {
      const int f = g.face(a, i, j, k);
      if (inverse_mass_[f] == 0.0) return;
      const Vec3i hi(i, j, k), lo = hi - Vec3i::Unit(a);
      const double push = (g.inside(lo) ? pressure[g.cell(lo)] : 0.0) - (g.inside(hi) ? pressure[g.cell(hi)] : 0.0);
      z[f] += inverse_mass_[f] * area * push;
    });
}

int PressureProjection::project(std::span<const double> r, double tolerance, std::span<double> z,
                                std::span<double> pressure) {
  const MacGrid& g = *grid_;
  double fastest = 0.0, most = 0.0;
  for (std::size_t f = 0; f < z.size(); ++f) {
    z[f] = inverse_mass_[f] > 0.0 ? inverse_mass_[f] * r[f] : 0.0;
    fastest = std::max(fastest, std::abs(z[f]));
  }
  for (std::size_t c = 0; c < g.cells(); ++c)
    if (!wet_->cell[c]) pressure[c] = 0.0;
  add_push(pressure, z);
  flow_.resize(g.cells());
  flow(z, flow_);
  for (double& x : flow_) {
    x = -x;
    most = std::max(most, std::abs(x));
  }
  change_.assign(g.cells(), 0.0);
  const double floor = kRounding * g.dx * g.dx * fastest;
  const int iterations = poisson_.solve(flow_, std::max(tolerance * most, floor), kMaxIterations, change_);
  add_push(change_, z);
  for (std::size_t c = 0; c < g.cells(); ++c) pressure[c] += change_[c];
  return iterations;
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
          if (at[a] == 0 && wet_->kind[g.face(a, at)] == WetFaces::Kind::Wall) sum[a] += p;
          if (at[a] + 1 == g.n[a] && wet_->kind[g.face(a, at + Vec3i::Unit(a))] == WetFaces::Kind::Wall) sum[a] -= p;
        }
      }
  return g.dx * g.dx * sum;
}

}  // namespace brim
