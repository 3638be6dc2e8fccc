#include "brim/body/grid_fluid/grid_poisson.h"

#include <cmath>

#include "brim/core/error.h"

namespace brim {

namespace {

/// [cells] of the coarsest level, along the longest side.
constexpr int kCoarsest = 4;
constexpr int kSweeps = 2, kCoarsestSweeps = 16;
/// See the class: coarse matrices are halved.
constexpr double kCoarseScale = 0.5;

double dot(std::span<const double> a, std::span<const double> b) {
  return ordered_sum(a.size(), [&](std::size_t begin, std::size_t end) {
    double s = 0.0;
    for (std::size_t i = begin; i < end; ++i) s += a[i] * b[i];
    return s;
  });
}

double largest(std::span<const double> a) {
  double most = 0.0;
  for (const double x : a) most = std::max(most, std::abs(x));
  return most;
}

/// Sum of a x over the six neighbours.
inline double neighbours(const GridPoisson::Level& l, const double* x, int c, int i, int j, int k) {
  const int sy = l.n.x(), sz = l.n.x() * l.n.y();
  double s = 0.0;
  if (i > 0) s += l.coupling[0][c - 1] * x[c - 1];
  if (i + 1 < l.n.x()) s += l.coupling[0][c] * x[c + 1];
  if (j > 0) s += l.coupling[1][c - sy] * x[c - sy];
  if (j + 1 < l.n.y()) s += l.coupling[1][c] * x[c + sy];
  if (k > 0) s += l.coupling[2][c - sz] * x[c - sz];
  if (k + 1 < l.n.z()) s += l.coupling[2][c] * x[c + sz];
  return s;
}

void resize(GridPoisson::Level& l, const Vec3i& n) {
  l.n = n;
  const auto cells = static_cast<std::size_t>(n.x()) * n.y() * n.z();
  l.diagonal.assign(cells, 0.0);
  for (auto& c : l.coupling) c.assign(cells, 0.0);
  l.x.resize(cells), l.b.resize(cells), l.r.resize(cells), l.inverse.resize(cells);
}

void invert_diagonal(GridPoisson::Level& l) {
  for (std::size_t c = 0; c < l.diagonal.size(); ++c) l.inverse[c] = l.diagonal[c] > 0.0 ? 1.0 / l.diagonal[c] : 0.0;
}

}  // namespace

void GridPoisson::reset(const Vec3i& n) {
  if (levels_.empty()) levels_.emplace_back();
  resize(levels_.front(), n);
  count_ = 1;
}

void GridPoisson::finish() {
  invert_diagonal(levels_.front());
  while (levels_[count_ - 1].n.maxCoeff() > kCoarsest) {
    if (levels_.size() == count_) levels_.emplace_back();
    coarsen(levels_[count_ - 1], levels_[count_]);
    ++count_;
  }
}

void GridPoisson::coarsen(const Level& fine, Level& coarse) {
  resize(coarse, (fine.n + Vec3i::Ones()) / 2);
  for_places(coarse.n, [&](int I, int J, int K) {
    const int C = I + coarse.n.x() * (J + coarse.n.y() * K);
    double diagonal = 0.0;
    std::array<double, 3> outer{};
    for (int k = 2 * K; k < std::min(2 * K + 2, fine.n.z()); ++k)
      for (int j = 2 * J; j < std::min(2 * J + 2, fine.n.y()); ++j)
        for (int i = 2 * I; i < std::min(2 * I + 2, fine.n.x()); ++i) {
          const int c = i + fine.n.x() * (j + fine.n.y() * k);
          const std::array<int, 3> at = {i, j, k};
          diagonal += fine.diagonal[c];
          for (int a = 0; a < 3; ++a) {
            // An even place couples within the coarse cell, an odd one with the next.
            if (at[a] % 2 == 0)
              diagonal -= 2.0 * fine.coupling[a][c];
            else
              outer[a] += fine.coupling[a][c];
          }
        }
    for (int a = 0; a < 3; ++a) coarse.coupling[a][C] = kCoarseScale * outer[a];
    coarse.diagonal[C] = kCoarseScale * std::max(diagonal, 0.0);
  });
  // Rounding must not leave a diagonal below its couplings, nor a cell that is coupled to nothing at all.
  for_places(coarse.n, [&](int i, int j, int k) {
    const int c = i + coarse.n.x() * (j + coarse.n.y() * k);
    coarse.x[c] = 1.0;
  });
  for_places(coarse.n, [&](int i, int j, int k) {
    const int c = i + coarse.n.x() * (j + coarse.n.y() * k);
    coarse.diagonal[c] = std::max(coarse.diagonal[c], neighbours(coarse, coarse.x.data(), c, i, j, k));
  });
  invert_diagonal(coarse);
}

void GridPoisson::smooth(Level& l, bool forth) {
  for (int half = 0; half < 2; ++half) {
    const int colour = forth ? half : 1 - half;
    parallel_for(static_cast<std::size_t>(l.n.z()), [&](std::size_t plane) {
      const int k = static_cast<int>(plane);
      for (int j = 0; j < l.n.y(); ++j)
        for (int i = (colour + j + k) % 2; i < l.n.x(); i += 2) {
          const int c = i + l.n.x() * (j + l.n.y() * k);
          if (l.inverse[c] > 0.0) l.x[c] = (l.b[c] + neighbours(l, l.x.data(), c, i, j, k)) * l.inverse[c];
        }
    });
  }
}

void GridPoisson::residual(Level& l) const {
  for_places(l.n, [&](int i, int j, int k) {
    const int c = i + l.n.x() * (j + l.n.y() * k);
    l.r[c] = l.inverse[c] > 0.0 ? l.b[c] - l.diagonal[c] * l.x[c] + neighbours(l, l.x.data(), c, i, j, k) : 0.0;
  });
}

void GridPoisson::cycle(std::size_t at) {
  Level& l = levels_[at];
  std::fill(l.x.begin(), l.x.end(), 0.0);
  if (at + 1 == count_) {
    for (int s = 0; s < kCoarsestSweeps; ++s) smooth(l, true);
    for (int s = 0; s < kCoarsestSweeps; ++s) smooth(l, false);
    return;
  }
  for (int s = 0; s < kSweeps; ++s) smooth(l, true);
  residual(l);
  Level& coarse = levels_[at + 1];
  for_places(coarse.n, [&](int I, int J, int K) {
    double sum = 0.0;
    for (int k = 2 * K; k < std::min(2 * K + 2, l.n.z()); ++k)
      for (int j = 2 * J; j < std::min(2 * J + 2, l.n.y()); ++j)
        for (int i = 2 * I; i < std::min(2 * I + 2, l.n.x()); ++i) sum += l.r[i + l.n.x() * (j + l.n.y() * k)];
    coarse.b[I + coarse.n.x() * (J + coarse.n.y() * K)] = sum;
  });
  cycle(at + 1);
  for_places(l.n, [&](int i, int j, int k) {
    const int c = i + l.n.x() * (j + l.n.y() * k);
    if (l.inverse[c] > 0.0) l.x[c] += coarse.x[i / 2 + coarse.n.x() * (j / 2 + coarse.n.y() * (k / 2))];
  });
  for (int s = 0; s < kSweeps; ++s) smooth(l, false);
}

void GridPoisson::apply(std::span<const double> x, std::span<double> y) const {
  const Level& l = levels_.front();
  for_places(l.n, [&](int i, int j, int k) {
    const int c = i + l.n.x() * (j + l.n.y() * k);
    y[c] = l.inverse[c] > 0.0 ? l.diagonal[c] * x[c] - neighbours(l, x.data(), c, i, j, k) : 0.0;
  });
}

int GridPoisson::solve(std::span<const double> b, double tolerance, int max_iterations, std::span<double> x) {
  Level& fine = levels_.front();
  const std::size_t n = fine.diagonal.size();
  BRIM_CHECK(b.size(), ==, n);
  BRIM_CHECK(x.size(), ==, n);
  r_.resize(n), z_.resize(n), p_.resize(n), y_.resize(n);
  for (std::size_t c = 0; c < n; ++c)
    if (!(fine.inverse[c] > 0.0)) x[c] = 0.0;
  apply(x, y_);
  for (std::size_t c = 0; c < n; ++c) r_[c] = fine.inverse[c] > 0.0 ? b[c] - y_[c] : 0.0;
  int iterations = 0;
  double rz = 0.0;
  while (largest(r_) > tolerance && iterations < max_iterations) {
    fine.b = r_;
    cycle(0);
    const double next = dot(r_, fine.x);
    if (!(next > 0.0) || !std::isfinite(next)) break;
    const double ratio = iterations > 0 ? next / rz : 0.0;
    rz = next;
    for (std::size_t c = 0; c < n; ++c) p_[c] = iterations > 0 ? fine.x[c] + ratio * p_[c] : fine.x[c];
    apply(p_, y_);
    const double curvature = dot(p_, y_);
    if (!(curvature > 0.0)) break;
    const double step = rz / curvature;
    for (std::size_t c = 0; c < n; ++c) {
      x[c] += step * p_[c];
      r_[c] -= step * y_[c];
    }
    ++iterations;
  }
  return iterations;
}

}  // namespace brim
