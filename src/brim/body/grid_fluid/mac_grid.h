#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "brim/core/parallel.h"
#include "brim/core/simd.h"
#include "brim/math/types.h"

namespace brim {

/// Staggered grid of a box (Harlow and Welch 1965): scalars at the centres of cubic cells, the component of velocity
/// along axis a at the centres of the faces across a.
///
///        v(i,j+1)            cells (i, j, k), 0 <= i < n.x and so on, x fastest
///      +----^----+           face (a, i, j, k): the low face of cell (i, j, k) across axis a
///  u(i)>  p(i,j) >u(i+1)     faces are stored for (n.x+1)(n.y+1)(n.z+1) places, three a place, so that all components
///      +----^----+           have one numbering; a few of them lie outside the box and are never used
///         v(i,j)
struct MacGrid {
  Vec3 origin = Vec3::Zero();  ///< [m] low corner of the box
  double dx = 1.0;             ///< [m] side of a cell
  Vec3i n = Vec3i::Ones();     ///< cells along x, y, z

  std::size_t cells() const { return static_cast<std::size_t>(n.x()) * n.y() * n.z(); }
  std::size_t faces() const { return 3 * static_cast<std::size_t>(n.x() + 1) * (n.y() + 1) * (n.z() + 1); }
  int cell(int i, int j, int k) const { return i + n.x() * (j + n.y() * k); }
  int cell(const Vec3i& c) const { return cell(c.x(), c.y(), c.z()); }
  int face(int a, int i, int j, int k) const { return 3 * (i + (n.x() + 1) * (j + (n.y() + 1) * k)) + a; }
  int face(int a, const Vec3i& c) const { return face(a, c.x(), c.y(), c.z()); }
  /// Stride of the cell number along an axis.
  int cell_stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? n.x() : n.x() * n.y(); }
  /// Stride of the face number along an axis.
  int face_stride(int axis) const { return 3 * (axis == 0 ? 1 : axis == 1 ? n.x() + 1 : (n.x() + 1) * (n.y() + 1)); }
  /// Number of faces across axis a along x, y, z.
  Vec3i face_count(int a) const { return n + Vec3i::Unit(a); }

  Vec3 cell_center(int i, int j, int k) const { return origin + dx * Vec3(i + 0.5, j + 0.5, k + 0.5); }
  Vec3 face_offset(int a) const { return Vec3::Constant(0.5) - 0.5 * Vec3::Unit(a); }
  Vec3 face_position(int a, int i, int j, int k) const { return origin + dx * (Vec3(i, j, k) + face_offset(a)); }
  /// Cell that contains x, or the nearest one.
  int cell_at(const Vec3& x) const {
    return cell(((x - origin) / dx)
                    .array()
                    .floor()
                    .cwiseMax(-1.0)
                    .cwiseMin(n.array().cast<double>())
                    .cast<int>()
                    .max(0)
                    .min(n.array() - 1));
  }
  Aabb box() const { return {origin, origin + dx * n.cast<double>()}; }
  bool inside(const Vec3i& c) const { return (c.array() >= 0).all() && (c.array() < n.array()).all(); }
};

/// Calls f(i, j, k) for all places of a box of counts; parallel over planes, f may write only data of its own place.
template <class F>
void for_places(const Vec3i& count, const F& f) {
  parallel_for(static_cast<std::size_t>(count.z()), [&](std::size_t k) {
    for (int j = 0; j < count.y(); ++j)
      for (int i = 0; i < count.x(); ++i) f(i, j, static_cast<int>(k));
  });
}

/// Layers k of a grid, [begin, end).
struct Layers {
  int begin = 0, end = 0;
  Layers grown_by(int n) const { return {begin - n, end + n}; }
};

/// The same for the places in some layers of the box alone.
template <class F>
void for_places(const Vec3i& count, const Layers& layers, const F& f) {
  const int begin = std::max(layers.begin, 0), end = std::min(layers.end, count.z());
  for_places({count.x(), count.y(), std::max(0, end - begin)}, [&](int i, int j, int k) { f(i, j, begin + k); });
}

/// Position of a coordinate between samples 0 .. count−1, clamped at the ends.
struct SamplePlace {
  int low;   ///< lower sample
  int step;  ///< to the upper one: 1, or 0 when there is only one sample
  double t;  ///< [0, 1]
  BRIM_INLINE SamplePlace(double s, int count) {
    s = std::clamp(s, 0.0, static_cast<double>(count - 1));
    low = std::min(static_cast<int>(s), std::max(count - 2, 0));
    step = count > 1 ? 1 : 0;
    t = s - low;
  }
};

/// Trilinear value of cell samples at x, constant beyond the outermost centres.
BRIM_INLINE double sample_cells(const MacGrid& g, std::span<const double> f, const Vec3& x) {
  const Vec3 s = (x - g.origin) / g.dx - Vec3::Constant(0.5);
  const SamplePlace X(s.x(), g.n.x()), Y(s.y(), g.n.y()), Z(s.z(), g.n.z());
  const double* p = f.data() + g.cell(X.low, Y.low, Z.low);
  const int dx = X.step, dy = Y.step * g.cell_stride(1), dz = Z.step * g.cell_stride(2);
  const auto line = [&](const double* q) { return q[0] + X.t * (q[dx] - q[0]); };
  const auto plane = [&](const double* q) {
    const double a = line(q);
    return a + Y.t * (line(q + dy) - a);
  };
  const double a = plane(p);
  return a + Z.t * (plane(p + dz) - a);
}

/// Trilinear component a of the velocity at x.
BRIM_INLINE double sample_face(const MacGrid& g, std::span<const double> u, int a, const Vec3& x) {
  const Vec3 s = (x - g.origin) / g.dx - g.face_offset(a);
  const Vec3i count = g.face_count(a);
  const SamplePlace X(s.x(), count.x()), Y(s.y(), count.y()), Z(s.z(), count.z());
  const double* p = u.data() + g.face(a, X.low, Y.low, Z.low);
  const int dx = X.step * g.face_stride(0), dy = Y.step * g.face_stride(1), dz = Z.step * g.face_stride(2);
  const auto line = [&](const double* q) { return q[0] + X.t * (q[dx] - q[0]); };
  const auto plane = [&](const double* q) {
    const double b = line(q);
    return b + Y.t * (line(q + dy) - b);
  };
  const double b = plane(p);
  return b + Z.t * (plane(p + dz) - b);
}

inline Vec3 sample_velocity(const MacGrid& g, std::span<const double> u, const Vec3& x) {
  return Vec3(sample_face(g, u, 0, x), sample_face(g, u, 1, x), sample_face(g, u, 2, x));
}

/// Position of the material at x a time dt ago, by the midpoint rule.
inline Vec3 trace_back(const MacGrid& g, std::span<const double> u, const Vec3& x, double dt) {
  const Vec3 middle = x - 0.5 * dt * sample_velocity(g, u, x);
  return x - dt * sample_velocity(g, u, middle);
}

}  // namespace brim
