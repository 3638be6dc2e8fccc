#include "brim/body/grid_fluid/face_map.h"

#include <cmath>

#include "brim/core/error.h"

namespace brim {

namespace {

/// [cells] standard deviation of the kernel K, and where it is cut off.
constexpr double kWidth = 0.75, kReach = 2.0;
/// [cells] depth below the surface at which a point belongs to the matter, not to the surface.
constexpr double kDeep = 2.0;
/// K, but for its constant, which makes it end at the cut. @param t2  [cells²]
double gauss(double t2) { return std::exp(-t2 / (2.0 * kWidth * kWidth)); }
/// ε of the class: below it the surface around a point is too ragged to have a normal.
constexpr double kLeastArea = 0.1;

/// Σ_e e φ(x + dx e) over the 27 offsets e of a cube: the slope of φ over two cells, up to its length. Along each axis
/// the three interpolated samples take four cells, so that the whole sum is one product of weights over 4x4x4 cells.
Vec3 slope_of_two_cells(const MacGrid& g, std::span<const double> phi, const Vec3& x) {
  const Vec3 s = (x - g.origin) / g.dx - Vec3::Constant(0.5);
  std::array<std::array<int, 4>, 3> at;
  std::array<std::array<double, 4>, 3> sum, difference;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const double low = std::floor(std::clamp(s[axis], -2.0, g.n[axis] + 1.0));
    const double t = std::clamp(s[axis] - low, 0.0, 1.0);
    for (int m = 0; m < 4; ++m)
      at[a][static_cast<std::size_t>(m)] =
          std::clamp(static_cast<int>(low) - 1 + m, 0, g.n[axis] - 1) * g.cell_stride(static_cast<int>(a));
    sum[a] = {1.0 - t, 1.0, 1.0, t};
    difference[a] = {t - 1.0, -t, 1.0 - t, t};
  }
  Vec3 slope = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t j = 0; j < 4; ++j) {
      const double* row = phi.data() + at[1][j] + at[2][k];
      const double p0 = row[at[0][0]], p1 = row[at[0][1]], p2 = row[at[0][2]], p3 = row[at[0][3]];
      const double along = sum[0][0] * p0 + sum[0][1] * p1 + sum[0][2] * p2 + sum[0][3] * p3;
      const double across =
          difference[0][0] * p0 + difference[0][1] * p1 + difference[0][2] * p2 + difference[0][3] * p3;
      slope += Vec3(across * sum[1][j] * sum[2][k], along * difference[1][j] * sum[2][k],
                    along * sum[1][j] * difference[2][k]);
    }
  return slope;
}

/// Calls f(face, weight) for the wet faces across axis a around x, Σ weight = 1, and returns whether there are any.
template <class F>
bool interpolate(const MacGrid& g, const WetFaces& wet, int a, const Vec3& x, const F& f) {
  const Vec3i count = g.face_count(a);
  const Vec3 s = (x - g.origin) / g.dx - g.face_offset(a);
  const SamplePlace place[3] = {{s.x(), count.x()}, {s.y(), count.y()}, {s.z(), count.z()}};
  const Vec3i low(place[0].low, place[1].low, place[2].low);
  std::array<int, 8> face;
  std::array<double, 8> weight;
  double sum = 0.0;
  for (int c = 0; c < 8; ++c) {
    face[c] = g.face(a, low);
    weight[c] = 1.0;
    for (int b = 0; b < 3; ++b) {
      const bool high = (c >> b) & 1;
      face[c] += high ? place[b].step * g.face_stride(b) : 0;
      weight[c] *= high ? place[b].t : 1.0 - place[b].t;
    }
    weight[c] *= wet.share[face[c]];  // zero where dry
    sum += weight[c];
  }
  if (sum > 1e-6) {
    for (int c = 0; c < 8; ++c)
      if (weight[c] > 0.0) f(face[c], weight[c] / sum);
    return true;
  }
  // Nothing wet around: the nearest wet face.
  double nearest = std::numeric_limits<double>::infinity();
  int best = -1;
  const Vec3i first = (low - Vec3i::Constant(2)).cwiseMax(0),
              last = (low + Vec3i::Constant(3)).cwiseMin(count - Vec3i::Ones());
  for (int k = first.z(); k <= last.z(); ++k)
    for (int j = first.y(); j <= last.y(); ++j)
      for (int i = first.x(); i <= last.x(); ++i) {
        const int candidate = g.face(a, i, j, k);
        if (wet.kind[candidate] == WetFaces::Kind::Dry) continue;
        const double d = (g.face_position(a, i, j, k) - x).squaredNorm();
        if (d < nearest) nearest = d, best = candidate;
      }
  if (best >= 0) f(best, 1.0);
  return best >= 0;
}

/// Calls f(face, axis, weight) for the surface faces around x: weight K, signed towards the dry cell.
template <class F>
void surface_faces(const MacGrid& g, const SurfaceFaces& surface, const Vec3& x, const F& f) {
  static const double end = gauss(kReach * kReach);
  const Vec3 s = (x - g.origin) / g.dx - Vec3::Constant(0.5);
  const double reach = kReach + 1.0;  // from the dry cell to where the surface cuts the line to the wet one
  const Vec3i first = (s.array() - reach).ceil().cast<int>().max(0);
  const Vec3i last = (s.array() + reach).floor().cast<int>().min(g.n.array() - 1);
  surface.for_cuts(first, last, [&](const SurfaceFaces::Cut& c) {
    Vec3 cut = c.cell - s;
    cut[c.axis] += c.way;
    const double t2 = cut.squaredNorm();
    if (t2 <= kReach * kReach) f(c.face, c.axis, c.sign * (gauss(t2) - end));
  });
}

}  // namespace

Vec3 surface_row(const MacGrid& g, const WetFaces& wet, const SurfaceFaces& surface, std::span<const double> phi,
                 SurfaceMotion motion, const Vec3& x, std::vector<FaceWeight>& row) {
  row.clear();
  const auto ask_matter = [&](const Vec3& y, const Mat3& share) {
    bool found = true;
    for (int a = 0; a < 3; ++a)
      found = interpolate(g, wet, a, y, [&](int face, double w) { row.push_back({face, w * share.col(a)}); }) && found;
    if (!found) row.clear();
    return found;
  };
  const double depth = sample_cells(g, phi, x);
  // Deep inside, at the walls of the box, the fluid has no surface: its matter is asked there, with shear and all.
  if (depth < -kDeep * g.dx) {
    ask_matter(x, Mat3::Identity());
    return Vec3::Zero();
  }
  // The point of the surface nearest to x, and the mean normal around it.
  Vec3 slope, n = slope_of_two_cells(g, phi, x);
  for (int a = 0; a < 3; ++a) {
    const Vec3 e = 0.5 * g.dx * Vec3::Unit(a);
    slope[a] = sample_cells(g, phi, x + e) - sample_cells(g, phi, x - e);
  }
  slope /= std::max(slope.norm(), 1e-12 * g.dx);
  n /= std::max(n.norm(), 1e-12 * g.dx);
  const Vec3 at = x - depth * slope;

  Vec3 area = Vec3::Zero();
  surface_faces(g, surface, at, [&](int face, int a, double k) {
    area[a] += k;
    row.push_back({face, Vec3(k, 0.0, 0.0)});
  });
  const double along = std::max(area.dot(n), 0.0);
  const double part = along * along / (along * along + kLeastArea * kLeastArea);
  for (FaceWeight& e : row) e.weight = (part * e.weight.x() / std::max(along, 1e-12)) * n;
  // What the flow through the surface does not tell, the matter does. Where g and n differ, a fluid that slips is
  // better left alone: the difference would stir it.
  Mat3 rest = Mat3::Identity();
  if (motion == SurfaceMotion::Sticks)
    rest -= (part / std::max(along, 1e-12)) * n * area.transpose();
  else
    rest = (motion == SurfaceMotion::Follows ? rest : Mat3(n * n.transpose())) - part * n * n.transpose();
  if (!ask_matter(at, rest) || motion == SurfaceMotion::Sticks) return Vec3::Zero();
  return (part / std::max(along, 1e-12) * area + (1.0 - part) * n).normalized();
}

Vec3 surface_velocity(const MacGrid& g, const WetFaces& wet, const SurfaceFaces& surface, std::span<const double> phi,
                      SurfaceMotion motion, std::span<const double> v, const Vec3& x, std::vector<FaceWeight>& row) {
  surface_row(g, wet, surface, phi, motion, x, row);
  Vec3 u = Vec3::Zero();
  for (const FaceWeight& e : row) u += v[e.face] * e.weight;
  return u;
}

void FaceMap::reset(const MacGrid& g, const WetFaces& wet, std::span<const double> phi,
                    const std::function<SurfaceMotion(int)>& motion, std::span<const Vec3> points) {
  const std::size_t n = points.size();
  if (row_.size() < n) row_.resize(n);
  direction_.resize(n);
  if (n > 0) surface_.find(g, wet, phi);
  parallel_for(
      n,
      [&](std::size_t p) {
        direction_[p] = surface_row(g, wet, surface_, phi, motion(g.cell_at(points[p])), points[p], row_[p]);
      },
      64);
  row_start_.assign(n + 1, 0);
  for (std::size_t p = 0; p < n; ++p) row_start_[p + 1] = row_start_[p] + row_[p].size();
  entry_.resize(row_start_.back());
  for (std::size_t p = 0; p < n; ++p)
    std::copy(row_[p].begin(), row_[p].end(), entry_.begin() + static_cast<std::ptrdiff_t>(row_start_[p]));
}

void FaceMap::apply(std::span<const double> v, std::span<Vec3> u) const {
  BRIM_CHECK(u.size(), ==, points());
  parallel_for(
      points(),
      [&](std::size_t p) {
        Vec3 sum = Vec3::Zero();
        for (std::size_t e = row_start_[p]; e < row_start_[p + 1]; ++e) sum += v[entry_[e].face] * entry_[e].weight;
        u[p] = sum;
      },
      256);
}

void FaceMap::apply_transpose(std::span<const Vec3> f, std::span<double> Q) const {
  BRIM_CHECK(f.size(), ==, points());
  // In the order of the points, on one thread: the same bits always.
  for (std::size_t p = 0; p < points(); ++p)
    for (std::size_t e = row_start_[p]; e < row_start_[p + 1]; ++e) Q[entry_[e].face] += entry_[e].weight.dot(f[p]);
}

void FaceMap::add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const {
  BRIM_CHECK(K.size(), ==, points());
  for (std::size_t p = 0; p < points(); ++p) {
    if (K[p].isZero(0.0)) continue;
    for (std::size_t e = row_start_[p]; e < row_start_[p + 1]; ++e) {
      const int place = entry_[e].face / 3;
      const Vec3 Kw = K[p] * entry_[e].weight;
      auto block = D.block(first + place);
      for (std::size_t o = row_start_[p]; o < row_start_[p + 1]; ++o)
        if (entry_[o].face / 3 == place) block(entry_[o].face % 3, entry_[e].face % 3) += entry_[o].weight.dot(Kw);
    }
  }
}

}  // namespace brim
