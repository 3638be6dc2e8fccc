#include "brim/body/grid_fluid/level_set.h"

#include <cmath>

namespace brim {

namespace {
/// Slopes of φ next to the surface that count as those of a distance.
constexpr double kLeastSlope = 0.6, kMostSlope = 1.5;
}  // namespace

Vec3 LevelSet::gradient(std::span<const double> phi, int i, int j, int k) const {
  const std::array<int, 3> at = {i, j, k};
  const int c = grid_.cell(i, j, k);
  Vec3 g;
  for (int a = 0; a < 3; ++a) {
    const int s = grid_.cell_stride(a);
    const int lo = at[a] > 0 ? 1 : 0, hi = at[a] + 1 < grid_.n[a] ? 1 : 0;
    g[a] = lo + hi > 0 ? (phi[c + hi * s] - phi[c - lo * s]) / ((lo + hi) * grid_.dx) : 0.0;
  }
  return g;
}

void LevelSet::find_near(std::span<const double> phi) {
  for_places(grid_.n, [&](int i, int j, int k) {
    const std::array<int, 3> at = {i, j, k};
    const int c = grid_.cell(i, j, k);
    const bool in = phi[c] < 0.0;
    // Distance to the surface from where it cuts the lines to the neighbours; exact for planes that cut all three.
    double inverse2 = 0.0;
    for (int a = 0; a < 3; ++a) {
      double cut = std::numeric_limits<double>::infinity();
      for (const int side : {-1, 1}) {
        const int other = at[a] + side;
        if (other < 0 || other >= grid_.n[a]) continue;
        const double p = phi[c + side * grid_.cell_stride(a)];
        if ((p < 0.0) != in) cut = std::min(cut, grid_.dx * phi[c] / (phi[c] - p));
      }
      if (std::isfinite(cut)) inverse2 += 1.0 / (cut * cut + 1e-30);
    }
    near_[c] = inverse2 > 0.0;
    if (!near_[c]) return;
    const double slope = gradient(phi, i, j, k).norm();
    // What is nearly a distance is kept: every change here would move the surface, step after step.
    const bool good = slope > kLeastSlope && slope < kMostSlope && std::abs(phi[c]) < 1.2 * grid_.dx;
    scratch_[c] = good ? phi[c] : (in ? -1.0 : 1.0) / std::sqrt(inverse2);
  });
}

void LevelSet::redistance(std::span<double> phi) {
  find_near(phi);
  const double far = grid_.box().extent().norm();
  for_places(grid_.n, [&](int i, int j, int k) {
    const int c = grid_.cell(i, j, k);
    phi[c] = near_[c] ? scratch_[c] : (phi[c] < 0.0 ? -far : far);
  });
  sweep(phi);
}

void LevelSet::sweep(std::span<double> phi) const {
  const Vec3i& n = grid_.n;
  const double dx = grid_.dx;
  for (int pass = 0; pass < 8; ++pass) {
    const int sx = pass & 1 ? -1 : 1, sy = pass & 2 ? -1 : 1, sz = pass & 4 ? -1 : 1;
    for (int kk = 0; kk < n.z(); ++kk)
      for (int jj = 0; jj < n.y(); ++jj)
        for (int ii = 0; ii < n.x(); ++ii) {
          const std::array<int, 3> at = {sx > 0 ? ii : n.x() - 1 - ii, sy > 0 ? jj : n.y() - 1 - jj,
                                         sz > 0 ? kk : n.z() - 1 - kk};
          const int c = grid_.cell(at[0], at[1], at[2]);
          if (near_[c]) continue;
          std::array<double, 3> d;
          for (int a = 0; a < 3; ++a) {
            const int s = grid_.cell_stride(a);
            d[a] = std::numeric_limits<double>::infinity();
            if (at[a] > 0) d[a] = std::abs(phi[c - s]);
            if (at[a] + 1 < n[a]) d[a] = std::min(d[a], std::abs(phi[c + s]));
          }
          std::sort(d.begin(), d.end());
          double x = d[0] + dx;
          if (x > d[1]) {
            const double b = d[0] - d[1];
            x = 0.5 * (d[0] + d[1] + std::sqrt(std::max(0.0, 2.0 * dx * dx - b * b)));
            if (x > d[2]) {
              const double sum = d[0] + d[1] + d[2];
              const double squares = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
              x = (sum + std::sqrt(std::max(0.0, sum * sum - 3.0 * (squares - dx * dx)))) / 3.0;
            }
          }
          if (x < std::abs(phi[c])) phi[c] = phi[c] < 0.0 ? -x : x;
        }
  }
}

double LevelSet::cubic(std::span<const double> phi, const Vec3& x) const {
  const Vec3 s = (x - grid_.origin) / grid_.dx - Vec3::Constant(0.5);
  std::array<std::array<int, 4>, 3> at;
  std::array<std::array<double, 4>, 3> weight;
  for (int a = 0; a < 3; ++a) {
    const double p = std::clamp(s[a], 0.0, grid_.n[a] - 1.0);
    const int low = std::min(static_cast<int>(p), std::max(grid_.n[a] - 2, 0));
    const double t = p - low;
    // Catmull and Rom 1974.
    weight[a] = {0.5 * t * (-1.0 + t * (2.0 - t)), 1.0 + 0.5 * t * t * (3.0 * t - 5.0),
                 0.5 * t * (1.0 + t * (4.0 - 3.0 * t)), 0.5 * t * t * (t - 1.0)};
    for (int m = 0; m < 4; ++m) at[a][m] = std::clamp(low - 1 + m, 0, grid_.n[a] - 1);
  }
  double sum = 0.0;
  for (int m = 0; m < 4; ++m)
    for (int l = 0; l < 4; ++l) {
      const double w = weight[1][l] * weight[2][m];
      if (w == 0.0) continue;
      const double* row = phi.data() + grid_.cell(0, at[1][l], at[2][m]);
      sum += w * (weight[0][0] * row[at[0][0]] + weight[0][1] * row[at[0][1]] + weight[0][2] * row[at[0][2]] +
                  weight[0][3] * row[at[0][3]]);
    }
  return sum;
}

template <class F>
void LevelSet::for_eighths(std::span<const double> phi, int i, int j, int k, double s, const F& f) const {
  const double p = (phi[grid_.cell(i, j, k)] + s) / grid_.dx;
  if (p > 1.0) return;  // farther than half the diagonal
  // Each eighth of the cell counts by the plane through its own middle.
  const Vec3 g = p < -1.0 ? Vec3::Zero() : gradient(phi, i, j, k);
  const double length = g.norm();
  const double width = length > 1e-9 ? g.lpNorm<1>() / length : 1.0;  // extent of the unit cube along the normal
  const Vec3 n = length > 1e-9 ? Vec3(g / length) : Vec3::Zero();
  for (int c = 0; c < 8; ++c) {
    const double there = p + 0.25 * ((c & 1 ? g.x() : -g.x()) + (c & 2 ? g.y() : -g.y()) + (c & 4 ? g.z() : -g.z()));
    const double share = std::clamp(0.5 - 2.0 * there / width, 0.0, 1.0);
    const Vec3 at(c & 1 ? 0.25 : -0.25, c & 2 ? 0.25 : -0.25, c & 4 ? 0.25 : -0.25);
    // From the corner behind the surface, where there is hardly any fluid, to the middle, where all is.
    f(share, at - 0.25 * width * (1.0 - share) * n);
  }
}

double LevelSet::fraction(std::span<const double> phi, int i, int j, int k, double s) const {
  double sum = 0.0;
  for_eighths(phi, i, j, k, s, [&](double share, const Vec3&) { sum += share; });
  return 0.125 * sum;
}

Vec3 LevelSet::moment(std::span<const double> phi, int i, int j, int k) const {
  Vec3 sum = Vec3::Zero();
  for_eighths(phi, i, j, k, 0.0, [&](double share, const Vec3& x) { sum += share * x; });
  return 0.125 * grid_.dx * sum;
}

double LevelSet::volume(std::span<const double> phi, double s, double& area, std::span<const double> left) const {
  const double cell = grid_.dx * grid_.dx * grid_.dx, step = 1e-3 * grid_.dx;
  std::vector<double> slope(grid_.n.z());
  const double sum = ordered_sum(
      grid_.n.z(),
      [&](std::size_t begin, std::size_t) {
        const int k = static_cast<int>(begin);
        double v = 0.0, later = 0.0;
        for (int j = 0; j < grid_.n.y(); ++j)
          for (int i = 0; i < grid_.n.x(); ++i) {
            const double part = left.empty() ? 1.0 : left[grid_.cell(i, j, k)];
            if (part == 0.0) continue;
            v += part * fraction(phi, i, j, k, s);
            later += part * fraction(phi, i, j, k, s - step);
          }
        slope[begin] = later - v;
        return v;
      },
      1);
  area = 0.0;
  for (const double x : slope) area += x * cell / step;
  return sum * cell;
}

double LevelSet::correct_volume(std::span<double> phi, double wanted, double most, std::span<const double> left) const {
  double s = 0.0;
  for (int iteration = 0; iteration < 4; ++iteration) {
    double area = 0.0;
    const double v = volume(phi, s, area, left);
    if (!(area > 0.0) || std::abs(v - wanted) < 1e-9 * wanted) break;
    s = std::clamp(s + (v - wanted) / area, -most, most);
  }
  if (s != 0.0)
    for (double& p : phi) p += s;
  return -s;
}

}  // namespace brim
