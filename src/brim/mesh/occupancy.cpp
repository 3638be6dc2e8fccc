#include "brim/mesh/occupancy.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/isosurface.h"

namespace brim {

Aabb OccupancyGrid::matter_box() const {
  Vec3i lo = cells, hi = Vec3i::Constant(-1);
  for (int k = 0; k < cells.z(); ++k)
    for (int j = 0; j < cells.y(); ++j) {
      const std::uint8_t* row = share.data() + index(0, j, k);
      int first = 0, last = cells.x() - 1;
      while (first < cells.x() && row[first] == 0) ++first;
      if (first == cells.x()) continue;
      while (row[last] == 0) --last;
      lo = lo.cwiseMin(Vec3i(first, j, k));
      hi = hi.cwiseMax(Vec3i(last, j, k));
    }
  Aabb box;
  if (hi.x() < 0) return box;
  box.extend(origin + spacing * (lo.cast<double>() - Vec3::Constant(0.5)));
  box.extend(origin + spacing * (hi.cast<double>() + Vec3::Constant(0.5)));
  return box;
}

Vec3 OccupancyGrid::middle() const {
  std::array<std::vector<double>, 3> fullest;
  for (int a = 0; a < 3; ++a) fullest[a].assign(static_cast<std::size_t>(cells[a]), 0.0);
  for (int k = 0; k < cells.z(); ++k)
    for (int j = 0; j < cells.y(); ++j)
      for (int i = 0; i < cells.x(); ++i) {
        const double s = share[index(i, j, k)];
        fullest[0][i] = std::max(fullest[0][i], s);
        fullest[1][j] = std::max(fullest[1][j], s);
        fullest[2][k] = std::max(fullest[2][k], s);
      }
  constexpr double kHalf = 127.5;
  const Aabb all = matter_box();
  Vec3 x = all.center();
  for (int a = 0; a < 3; ++a) {
    const std::vector<double>& f = fullest[a];
    const auto full = [](double s) { return s > kHalf; };
    const auto first = std::ranges::find_if(f, full);
    if (first == f.end() || first == f.begin() || full(f.back())) continue;
    const auto last = std::find_if(f.rbegin(), f.rend(), full).base() - 1;
    // Centres beyond the half full places, and how far these lie from them.
    const double low = static_cast<double>(first - f.begin()) - (*first - kHalf) / (*first - *(first - 1));
    const double high = static_cast<double>(last - f.begin()) + (*last - kHalf) / (*last - *(last + 1));
    x[a] = origin[a] + 0.5 * spacing * (low + high);
  }
  return x;
}

namespace {

/// Calls put(cell, sum, samples) with the sum of of(intensity) over samples of each inner cell of a grid; those outside
/// of the image add nothing.
template <class Of, class Put>
void sample_cells(const VoxelImage& image, const OccupancyGrid& grid, const Of& of, const Put& put) {
  const Mat3 to_index = image.axes.inverse();
  const int per_side = std::max(2, static_cast<int>(std::ceil(2.0 * grid.spacing / image.finest_step() - 1e-6)));
  std::vector<Vec3> offset;  // of the samples within a cell, [voxels]
  for (int c = 0; c < per_side * per_side * per_side; ++c) {
    const Vec3i at(c % per_side, c / per_side % per_side, c / (per_side * per_side));
    const Vec3 u = (at.cast<double>() + Vec3::Constant(0.5)) / per_side - Vec3::Constant(0.5);
    offset.push_back(to_index * (grid.spacing * u));
  }
  parallel_for(static_cast<std::size_t>(grid.cells.z() - 2), [&](std::size_t slab) {
    const int k = static_cast<int>(slab) + 1;
    for (int j = 1; j + 1 < grid.cells.y(); ++j)
      for (int i = 1; i + 1 < grid.cells.x(); ++i) {
        const Vec3 center = to_index * (grid.center(i, j, k) - image.origin);
        double sum = 0.0, value = 0.0;
        for (const Vec3& u : offset)
          if (image.sample(center + u, value)) sum += of(value);
        put(grid.index(i, j, k), sum, static_cast<double>(offset.size()));
      }
  });
}

}  // namespace

OccupancyGrid sample_occupancy(const VoxelImage& image, const IntensityWindow& window, double spacing,
                               std::size_t max_cells) {
  BRIM_CHECK(image.values.size(), ==, image.count());
  if (!(spacing > 0.0) || !std::isfinite(spacing))
    throw InputError(fmt::format("volume: a cell of {} m is not allowed; must be positive and finite", spacing));
  OccupancyGrid grid;
  const Aabb box = image.box();
  const Vec3 n = (box.extent() / spacing).array().ceil() + 2.0;
  if (!(n.prod() <= static_cast<double>(max_cells)))
    throw InputError(fmt::format("volume: cells of {:.3g} m would be {:.3g} in number; {} are allowed", spacing,
                                 n.prod(), max_cells));
  grid.spacing = spacing;
  grid.cells = n.cast<int>();
  grid.origin = box.center() - 0.5 * spacing * (n - Vec3::Ones());
  grid.share.assign(static_cast<std::size_t>(n.prod()), 0);

  sample_cells(
      image, grid, [&](double value) { return window.share(value); },
      [&](std::size_t at, double sum, double samples) {
        grid.share[at] = static_cast<std::uint8_t>(std::lround(255.0 * sum / samples));
      });
  if (std::none_of(grid.share.begin(), grid.share.end(), [](std::uint8_t s) { return s >= 128; })) {
    const auto [least, most] = std::minmax_element(image.values.begin(), image.values.end());
    throw NoMatter(fmt::format(
        "volume: no matter is left: no cell of {:.3g} m is half filled by intensities of the window {:.6g} to {:.6g}; "
        "the image holds {:.6g} to {:.6g}",
        spacing, window.lo, window.hi, *least, *most));
  }
  return grid;
}

std::vector<float> cell_means(const VoxelImage& image, const OccupancyGrid& grid,
                              const std::function<double(double)>& of) {
  BRIM_CHECK(image.values.size(), ==, image.count());
  std::vector<float> mean(grid.share.size(), 0.0f);
  sample_cells(image, grid, of,
               [&](std::size_t at, double sum, double samples) { mean[at] = static_cast<float>(sum / samples); });
  return mean;
}

namespace {

/// Cells of joined_cells without their shares.
OccupancyGrid joined_frame(const OccupancyGrid& grid, int f) {
  OccupancyGrid out;
  out.spacing = f * grid.spacing;
  out.cells = ((grid.cells.array() + f - 1) / f + 2).matrix();
  out.origin = grid.origin + Vec3::Constant(0.5 * (f - 1) * grid.spacing - out.spacing);
  out.share.assign(static_cast<std::size_t>(out.cells.x()) * out.cells.y() * out.cells.z(), 0);
  return out;
}

/// Sums of values over the cells that are joined, of one layer: put(cell, sum).
template <class T, class Put>
void join_layer(const OccupancyGrid& grid, std::span<const T> value, int f, int k, const OccupancyGrid& out,
                const Put& put) {
  for (int j = 1; j + 1 < out.cells.y(); ++j)
    for (int i = 1; i + 1 < out.cells.x(); ++i) {
      double sum = 0.0;
      for (int c = 0; c < f * f * f; ++c) {
        const Vec3i at = f * (Vec3i(i, j, k) - Vec3i::Ones()) + Vec3i(c % f, c / f % f, c / (f * f));
        if ((at.array() < grid.cells.array()).all()) sum += value[grid.index(at.x(), at.y(), at.z())];
      }
      put(out.index(i, j, k), sum);
    }
}

/// Shares of one layer.
void join_shares(const OccupancyGrid& grid, int f, int k, OccupancyGrid& out) {
  join_layer<std::uint8_t>(grid, grid.share, f, k, out, [&](std::size_t at, double sum) {
    out.share[at] = static_cast<std::uint8_t>(std::lround(sum / (f * f * f)));
  });
}

}  // namespace

OccupancyGrid joined_cells(const OccupancyGrid& grid, int f) {
  BRIM_CHECK(f, >=, 1);
  OccupancyGrid out = joined_frame(grid, f);
  parallel_for(static_cast<std::size_t>(out.cells.z() - 2),
               [&](std::size_t slab) { join_shares(grid, f, static_cast<int>(slab) + 1, out); });
  return out;
}

std::vector<float> joined_means(const OccupancyGrid& grid, std::span<const float> values, int f) {
  BRIM_CHECK(f, >=, 1);
  BRIM_CHECK(values.size(), ==, grid.share.size());
  const OccupancyGrid frame = joined_frame(grid, f);
  std::vector<float> out(frame.share.size(), 0.0f);
  parallel_for(static_cast<std::size_t>(frame.cells.z() - 2), [&](std::size_t slab) {
    join_layer<float>(grid, values, f, static_cast<int>(slab) + 1, frame,
                      [&](std::size_t at, double sum) { out[at] = static_cast<float>(sum / (f * f * f)); });
  });
  return out;
}

OccupancyGrid halved_cells(const OccupancyGrid& grid) {
  OccupancyGrid out = joined_frame(grid, 2);
  for (int k = 1; k + 1 < out.cells.z(); ++k) join_shares(grid, 2, k, out);
  return out;
}

OccupancyGrid widened_cells(const OccupancyGrid& grid, int rings) {
  OccupancyGrid out;
  out.spacing = grid.spacing;
  out.cells = grid.cells + Vec3i::Constant(2 * rings);
  out.origin = grid.origin - Vec3::Constant(rings * grid.spacing);
  out.share.assign(static_cast<std::size_t>(out.cells.x()) * out.cells.y() * out.cells.z(), 0);
  for (int k = 0; k < grid.cells.z(); ++k)
    for (int j = 0; j < grid.cells.y(); ++j)
      std::copy_n(grid.share.begin() + static_cast<std::ptrdiff_t>(grid.index(0, j, k)), grid.cells.x(),
                  out.share.begin() + static_cast<std::ptrdiff_t>(out.index(rings, j + rings, k + rings)));
  return out;
}

namespace {

/// CellPieces of a grid: cells at least half filled that are joined across faces.
struct CellPieces {
  std::array<std::ptrdiff_t, 6> step;  ///< to a cell's neighbours; border cells are empty, so neighbours exist
  std::vector<std::int32_t> of;        ///< piece of each cell, from 1; 0: none
  std::vector<std::size_t> size{0};    ///< [cells] of each piece
};

CellPieces find_pieces(const OccupancyGrid& grid) {
  const std::ptrdiff_t row = grid.cells.x(), layer = row * grid.cells.y();
  CellPieces p{{-1, 1, -row, row, -layer, layer}, std::vector<std::int32_t>(grid.share.size(), 0)};
  std::vector<std::size_t> stack;
  for (std::size_t seed = 0; seed < grid.share.size(); ++seed) {
    if (grid.share[seed] < 128 || p.of[seed] != 0) continue;
    const auto number = static_cast<std::int32_t>(p.size.size());
    p.size.push_back(0);
    stack.assign(1, seed);
    p.of[seed] = number;
    while (!stack.empty()) {
      const std::size_t at = stack.back();
      stack.pop_back();
      ++p.size.back();
      for (const std::ptrdiff_t s : p.step) {
        const std::size_t next = at + static_cast<std::size_t>(s);
        if (grid.share[next] >= 128 && p.of[next] == 0) p.of[next] = number, stack.push_back(next);
      }
    }
  }
  return p;
}

/// Empties what belongs to no piece that stays, and is no neighbour of one. @return number of pieces there were
std::size_t keep(OccupancyGrid& grid, const CellPieces& p, const std::vector<bool>& stays) {
  std::vector<std::uint8_t> kept(grid.share.size(), 0);
  for (std::size_t at = 0; at < p.of.size(); ++at) {
    if (p.of[at] == 0 || !stays[static_cast<std::size_t>(p.of[at])]) continue;
    kept[at] = grid.share[at];
    for (const std::ptrdiff_t s : p.step) {
      const std::size_t next = at + static_cast<std::size_t>(s);
      if (p.of[next] == 0) kept[next] = grid.share[next];
    }
  }
  grid.share = std::move(kept);
  return p.size.size() - 1;
}

}  // namespace

std::size_t keep_largest_piece(OccupancyGrid& grid) {
  const CellPieces p = find_pieces(grid);
  std::vector<bool> stays(p.size.size(), false);
  const auto best = std::max_element(p.size.begin() + 1, p.size.end());
  if (best != p.size.end()) stays[static_cast<std::size_t>(best - p.size.begin())] = true;
  return keep(grid, p, stays);
}

std::size_t keep_piece_at(OccupancyGrid& grid, const Vec3& seed) {
  const CellPieces p = find_pieces(grid);
  std::vector<bool> stays(p.size.size(), false);
  double least = std::numeric_limits<double>::infinity();
  std::int32_t best = 0;
  for (int k = 0; k < grid.cells.z(); ++k)
    for (int j = 0; j < grid.cells.y(); ++j)
      for (int i = 0; i < grid.cells.x(); ++i) {
        const std::int32_t piece = p.of[grid.index(i, j, k)];
        const double away = piece != 0 ? (grid.center(i, j, k) - seed).squaredNorm() : least;
        if (away < least) least = away, best = piece;
      }
  if (best != 0) stays[static_cast<std::size_t>(best)] = true;
  return keep(grid, p, stays);
}

std::size_t keep_pieces_above(OccupancyGrid& grid, double volume) {
  const CellPieces p = find_pieces(grid);
  const double cell = grid.spacing * grid.spacing * grid.spacing;
  std::vector<bool> stays(p.size.size(), false);
  for (std::size_t n = 1; n < p.size.size(); ++n) stays[n] = static_cast<double>(p.size[n]) * cell >= volume;
  return keep(grid, p, stays);
}

namespace {

/// Σ w, the mean place, and Σ w x xᵀ about it, of cells as cubes that weigh w.
struct CellMoments {
  double sum = 0.0;
  Vec3 center = Vec3::Zero();
  Mat3 second = Mat3::Zero();
};

/// @param weight  of a cell by its number, times 255 per volume
template <class Weight>
CellMoments cell_moments(const OccupancyGrid& grid, const Weight& weight) {
  const double cell = grid.spacing * grid.spacing * grid.spacing / 255.0;
  double sum = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  const Vec3 middle = grid.center(0, 0, 0) + 0.5 * grid.spacing * grid.cells.cast<double>();
  for (int k = 0; k < grid.cells.z(); ++k)
    for (int j = 0; j < grid.cells.y(); ++j)
      for (int i = 0; i < grid.cells.x(); ++i) {
        const double s = weight(grid.index(i, j, k));
        if (s == 0.0) continue;
        const Vec3 x = grid.center(i, j, k) - middle;
        sum += s * cell;
        first += s * cell * x;
        second += s * cell * x * x.transpose();
      }
  if (!(sum > 0.0)) throw InputError("volume: there is no matter");
  const Vec3 c = first / sum;
  second -= sum * c * c.transpose();
  second += sum * grid.spacing * grid.spacing / 12.0 * Mat3::Identity();  // of the cubes themselves
  return {sum, middle + c, second};
}

}  // namespace

MassProperties mass_properties(const OccupancyGrid& grid, double density) {
  if (!(density > 0.0) || !std::isfinite(density))
    throw InputError(fmt::format("volume: density is {} kg/m³; it must be positive and finite", density));
  const CellMoments all = cell_moments(grid, [&](std::size_t at) { return static_cast<double>(grid.share[at]); });
  MassProperties m;
  m.volume = all.sum;
  m.mass = density * all.sum;
  m.center = all.center;
  m.inertia = density * (all.second.trace() * Mat3::Identity() - all.second);
  return m;
}

MassProperties mass_properties(const OccupancyGrid& grid, std::span<const float> density) {
  BRIM_CHECK(density.size(), ==, grid.share.size());
  MassProperties m = mass_properties(grid, 1.0);
  const CellMoments all = cell_moments(
      grid, [&](std::size_t at) { return grid.share[at] == 0 ? 0.0 : 255.0 * static_cast<double>(density[at]); });
  m.mass = all.sum;
  m.center = all.center;
  m.inertia = all.second.trace() * Mat3::Identity() - all.second;
  return m;
}

TriMesh display_surface(const OccupancyGrid& grid, std::size_t max_nodes) {
  int f = 1;
  while ((grid.cells.cast<double>() / f).prod() > static_cast<double>(max_nodes)) ++f;
  // The ring of empty cells closes the surface whatever the factor.
  const OccupancyGrid coarse = joined_cells(grid, f);
  std::vector<float> value(coarse.share.size());
  std::transform(coarse.share.begin(), coarse.share.end(), value.begin(),
                 [](std::uint8_t s) { return 0.5f - static_cast<float>(s) / 255.0f; });
  return isosurface({coarse.origin, coarse.spacing, coarse.cells, value});
}

}  // namespace brim
