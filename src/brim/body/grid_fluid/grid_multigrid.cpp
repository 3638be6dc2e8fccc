#include "brim/body/grid_fluid/grid_multigrid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "brim/core/parallel.h"
#include "brim/core/simd.h"

namespace brim {

namespace {

/// [cells] of the coarsest level, along the longest side.
constexpr int kCoarsestSide = 4;
/// Degree of the smoother, and the part of the spectrum [2/part, 2] that it is for; on the coarsest level nearly all.
constexpr int kDegree = 4, kCoarsestDegree = 24;
constexpr double kSmoothed = 10.0, kCoarsestSmoothed = 200.0;
/// See the class: coarse matrices are halved.
constexpr double kCoarseScale = 0.5;
/// Rows that a thread takes at once: a few microseconds of work.
constexpr std::size_t kRowsOfWork = 512;

struct Couplings {
  const float *x, *y, *z;
  std::size_t row, plane;
};

BRIM_INLINE WideFloats load(const float* p) {
  WideFloats w;
  std::memcpy(&w, p, sizeof w);
  return w;
}

/// Sum of a x over the six neighbours of eight cells.
BRIM_INLINE WideFloats neighbours(const Couplings& a, const float* x, std::size_t c) {
  const WideFloats sx = load(a.x + c - 1) * load(x + c - 1) + load(a.x + c) * load(x + c + 1);
  const WideFloats sy = load(a.y + c - a.row) * load(x + c - a.row) + load(a.y + c) * load(x + c + a.row);
  const WideFloats sz = load(a.z + c - a.plane) * load(x + c - a.plane) + load(a.z + c) * load(x + c + a.plane);
  return (sx + sy) + sz;
}

/// step = keep step + gain (b − A x), out = x + step, row by row.
BRIM_WIDE void smooth_rows(const Couplings& a, std::span<const std::size_t> rows, const float* b, const float* x,
                           float keep, float gain, float* step, float* out) {
  for (const std::size_t first : rows)
    for (std::size_t c = first; c < first + a.row; c += kWideLanes) {
      const WideFloats now = load(x + c), r = (load(b + c) - now) + neighbours(a, x, c);
      const WideFloats s = keep * load(step + c) + gain * r;
      store_lanes(step + c, s);
      store_lanes(out + c, now + s);
    }
}

/// out = b − A x
BRIM_WIDE void residual_rows(const Couplings& a, std::span<const std::size_t> rows, const float* b, const float* x,
                             float* out) {
  for (const std::size_t first : rows)
    for (std::size_t c = first; c < first + a.row; c += kWideLanes)
      store_lanes(out + c, (load(b + c) - load(x + c)) + neighbours(a, x, c));
}

/// step = out = gain b
BRIM_WIDE void start_rows(std::span<const std::size_t> rows, std::size_t row, const float* b, float gain, float* step,
                          float* out) {
  for (const std::size_t first : rows)
    for (std::size_t c = first; c < first + row; c += kWideLanes) {
      const WideFloats s = gain * load(b + c);
      store_lanes(step + c, s);
      store_lanes(out + c, s);
    }
}

template <class F>
void for_rows(std::span<const std::size_t> rows, const F& f) {
  parallel_blocks(rows.size(), kRowsOfWork,
                  [&](std::size_t begin, std::size_t end) { f(rows.subspan(begin, end - begin)); });
}

}  // namespace

void GridMultigrid::take(const GridMatrix& matrix, Level& level) {
  level.box = PaddedBox(matrix.n);
  const PaddedBox& box = level.box;
  for (std::vector<float>* array : {&level.scale, &level.root, &level.coupling[0], &level.coupling[1],
                                    &level.coupling[2], &level.b, &level.x, &level.other, &level.step})
    array->assign(box.size, 0.0f);
  level.rows.clear();
  box.for_cells([&](std::size_t at, std::size_t c) {
    if (!(matrix.diagonal[c] > 0.0)) return;
    level.root[at] = static_cast<float>(std::sqrt(matrix.diagonal[c]));
    level.scale[at] = 1.0f / level.root[at];
    const std::size_t first = box.row_of(at);
    if (level.rows.empty() || level.rows.back() != first) level.rows.push_back(first);
  });
  const std::array<std::size_t, 3> stride = {1, box.row, box.plane};
  box.for_cells([&](std::size_t at, std::size_t c) {
    for (std::size_t a = 0; a < 3; ++a)
      level.coupling[a][at] = static_cast<float>(matrix.coupling[a][c] * level.scale[at] * level.scale[at + stride[a]]);
  });
}

void GridMultigrid::set(const GridMatrix& matrix) {
  count_ = 0;
  const GridMatrix* given = &matrix;
  while (true) {
    if (levels_.size() == count_) levels_.emplace_back();
    take(*given, levels_[count_]);
    ++count_;
    if (given->n.maxCoeff() <= kCoarsestSide) break;
    GridMatrix& next = coarse_[count_ % 2];
    coarsen(*given, next);
    given = &next;
  }
}

void GridMultigrid::coarsen(const GridMatrix& fine, GridMatrix& coarse) {
  const Vec3i n = (fine.n + Vec3i::Ones()) / 2;
  coarse.reset(n);
  std::size_t c = 0;
  for (int k = 0; k < fine.n.z(); ++k)
    for (int j = 0; j < fine.n.y(); ++j)
      for (int i = 0; i < fine.n.x(); ++i, ++c) {
        const std::array<int, 3> at = {i, j, k};
        const auto C = static_cast<std::size_t>(i / 2 + n.x() * (j / 2 + n.y() * (k / 2)));
        coarse.diagonal[C] += kCoarseScale * fine.diagonal[c];
        for (std::size_t a = 0; a < 3; ++a) {
          // An even place couples within the coarse cell, an odd one with the next.
          if (at[a] % 2 == 0)
            coarse.diagonal[C] -= 2.0 * kCoarseScale * fine.coupling[a][c];
          else
            coarse.coupling[a][C] += kCoarseScale * fine.coupling[a][c];
        }
      }
  // Rounding must not leave a diagonal below its couplings, nor a cell that is coupled to nothing at all.
  const std::array<int, 3> stride = {1, n.x(), n.x() * n.y()};
  int C = 0;
  for (int k = 0; k < n.z(); ++k)
    for (int j = 0; j < n.y(); ++j)
      for (int i = 0; i < n.x(); ++i, ++C) {
        const std::array<int, 3> at = {i, j, k};
        double sum = 0.0;
        for (std::size_t a = 0; a < 3; ++a) {
          sum += coarse.coupling[a][static_cast<std::size_t>(C)];
          if (at[a] > 0) sum += coarse.coupling[a][static_cast<std::size_t>(C - stride[a])];
        }
        double& d = coarse.diagonal[static_cast<std::size_t>(C)];
        d = std::max(d, sum);
      }
}

/// Chebyshev's iteration for A' x = b over [2/part, 2]. @param from_zero  x starts from zero and need not be set
void GridMultigrid::smooth(Level& level, int degree, double part, bool from_zero) {
  const double lowest = 2.0 / part, middle = 0.5 * (2.0 + lowest), half = 0.5 * (2.0 - lowest);
  const Couplings a = {level.coupling[0].data(), level.coupling[1].data(), level.coupling[2].data(), level.box.row,
                       level.box.plane};
  double share = half / middle;  // of Chebyshev's recurrence
  for (int s = 0; s < degree; ++s) {
    double keep = 0.0, gain = 1.0 / middle;
    if (s > 0) {
      const double next = 1.0 / (2.0 * middle / half - share);
      keep = next * share, gain = 2.0 * next / half;
      share = next;
    }
    const auto k = static_cast<float>(keep), g = static_cast<float>(gain);
    for_rows(level.rows, [&](std::span<const std::size_t> rows) {
      if (s == 0 && from_zero)
        start_rows(rows, a.row, level.b.data(), g, level.step.data(), level.other.data());
      else
        smooth_rows(a, rows, level.b.data(), level.x.data(), k, g, level.step.data(), level.other.data());
    });
    level.x.swap(level.other);
  }
}

/// The residual of x into `other`.
void GridMultigrid::residual(Level& level) {
  const Couplings a = {level.coupling[0].data(), level.coupling[1].data(), level.coupling[2].data(), level.box.row,
                       level.box.plane};
  for_rows(level.rows, [&](std::span<const std::size_t> rows) {
    residual_rows(a, rows, level.b.data(), level.x.data(), level.other.data());
  });
}

/// The right-hand side of the coarse level: of the residual, s Σ r over the cells that are joined.
void GridMultigrid::restrict_to(Level& coarse, const Level& fine) {
  const PaddedBox &f = fine.box, &c = coarse.box;
  for_rows(coarse.rows, [&](std::span<const std::size_t> rows) {
    for (const std::size_t row : rows) {
      const auto [J, K] = c.place_of(row);
      float* to = coarse.b.data() + row;
      std::fill(to, to + c.n.x(), 0.0f);
      for (int k = 2 * K; k < std::min(2 * K + 2, f.n.z()); ++k)
        for (int j = 2 * J; j < std::min(2 * J + 2, f.n.y()); ++j) {
          // Behind a row of odd length there is a gap of zeros.
          const float *r = fine.other.data() + f.at(0, j, k), *root = fine.root.data() + f.at(0, j, k);
          for (int I = 0; I < c.n.x(); ++I) to[I] += r[2 * I] * root[2 * I] + r[2 * I + 1] * root[2 * I + 1];
        }
      const float* scale = coarse.scale.data() + row;
      for (int I = 0; I < c.n.x(); ++I) to[I] *= scale[I];
    }
  });
}

/// Adds what the coarse level found, constant over the cells that are joined.
void GridMultigrid::prolong_to(Level& fine, const Level& coarse) {
  const PaddedBox &f = fine.box, &c = coarse.box;
  for_rows(fine.rows, [&](std::span<const std::size_t> rows) {
    for (const std::size_t row : rows) {
      const auto [j, k] = f.place_of(row);
      const std::size_t from = c.at(0, j / 2, k / 2);
      const float *x = coarse.x.data() + from, *scale = coarse.scale.data() + from, *root = fine.root.data() + row;
      float* to = fine.x.data() + row;
      // A cell past an odd end is one of the gap, whose root is zero.
      for (int I = 0; I < c.n.x(); ++I) {
        const float found = x[I] * scale[I];
        to[2 * I] += root[2 * I] * found;
        to[2 * I + 1] += root[2 * I + 1] * found;
      }
    }
  });
}

void GridMultigrid::cycle(std::size_t at) {
  Level& level = levels_[at];
  if (at + 1 == count_) {
    smooth(level, kCoarsestDegree, kCoarsestSmoothed, true);
    return;
  }
  smooth(level, kDegree, kSmoothed, true);
  residual(level);
  restrict_to(levels_[at + 1], level);
  cycle(at + 1);
  prolong_to(level, levels_[at + 1]);
  smooth(level, kDegree, kSmoothed, false);
}

}  // namespace brim
