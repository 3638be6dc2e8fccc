#pragma once

#include <cstdint>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Body-centred cubic lattice: corners of cubes and their centres. A tetrahedron connects the centres of two cubes that
/// share a face with one edge of that face; all are congruent, 12 per cube.
/// ```
///   long edges (spacing):        corner - corner, centre - centre
///   short edges (√3/2 spacing):  corner - centre
/// ```
/// Nodes are numbered: all corners, x fastest, then all centres.
class BccLattice {
 public:
  /// Cubes that cover the box with a margin of at least 1.5 spacings, centred on it.
  BccLattice(const Aabb& box, double spacing) : BccLattice(box, Vec3::Constant(spacing)) {}
  /// The same with a spacing for each axis.
  BccLattice(const Aabb& box, const Vec3& spacing) : spacing_(spacing) {
    cells_ = (box.extent().cwiseQuotient(spacing).array().ceil().cast<int>() + 3).matrix();
    origin_ = box.center() - 0.5 * spacing.cwiseProduct(cells_.cast<double>());
    corners_ = (cells_.x() + 1) * (cells_.y() + 1) * (cells_.z() + 1);
  }

  /// The largest of the three, [m].
  double spacing() const { return spacing_.maxCoeff(); }
  std::int32_t node_count() const { return corners_ + cells_.prod(); }
  bool is_corner(std::int32_t node) const { return node < corners_; }

  Vec3i place(std::int32_t node) const {
    const bool corner = is_corner(node);
    const int n = corner ? node : node - corners_, nx = cells_.x() + corner, ny = cells_.y() + corner;
    return {n % nx, n / nx % ny, n / (nx * ny)};
  }
  Vec3 position(std::int32_t node) const {
    const double half = is_corner(node) ? 0.0 : 0.5;
    return origin_ + spacing_.cwiseProduct(place(node).cast<double>() + Vec3::Constant(half));
  }
  /// Parity of the node's position: neighbours along a long edge differ.
  bool is_even(std::int32_t node) const { return place(node).sum() % 2 == 0; }

  std::int32_t corner(const Vec3i& p) const { return p.x() + (cells_.x() + 1) * (p.y() + (cells_.y() + 1) * p.z()); }
  std::int32_t center(const Vec3i& p) const { return corners_ + p.x() + cells_.x() * (p.y() + cells_.y() * p.z()); }

  /// Calls f(tet), positive volume, in a fixed order.
  template <class F>
  void for_each_tet(const F& f) const {
    for_each_face([&](const Vec3i& cell, int axis) {
      for (int m = 0; m < 4; ++m) f(tet(cell, axis, m));
    });
  }

  /// Calls f(a, b) once for each edge of the tetrahedra (and some at the border).
  template <class F>
  void for_each_edge(const F& f) const {
    for (int k = 0; k <= cells_.z(); ++k)
      for (int j = 0; j <= cells_.y(); ++j)
        for (int i = 0; i <= cells_.x(); ++i) {
          const Vec3i p(i, j, k);
          for (int a = 0; a < 3; ++a)
            if (p[a] < cells_[a]) f(corner(p), corner(p + Vec3i::Unit(a)));
          if ((p.array() >= cells_.array()).any()) continue;
          for (int a = 0; a < 3; ++a)
            if (p[a] + 1 < cells_[a]) f(center(p), center(p + Vec3i::Unit(a)));
          for (int c = 0; c < 8; ++c) f(corner(p + Vec3i(c & 1, c >> 1 & 1, c >> 2)), center(p));
        }
  }

  /// Index of the tetrahedron that contains p in the order of for_each_tet.
  std::int64_t tet_at(const Vec3& p) const {
    const Vec3 x = (p - origin_).cwiseQuotient(spacing_);
    Vec3i cell = x.array().floor().cast<int>().matrix();
    const Vec3 from_center = x - cell.cast<double>() - Vec3::Constant(0.5);
    int axis = 0;
    from_center.cwiseAbs().maxCoeff(&axis);
    if (from_center[axis] < 0.0) cell -= Vec3i::Unit(axis);
    // Which edge of the face: the side of its centre line that lies farther out.
    const double u = from_center[(axis + 1) % 3], v = from_center[(axis + 2) % 3];
    const int m = std::abs(u) >= std::abs(v) ? (u >= 0.0 ? 1 : 3) : (v >= 0.0 ? 2 : 0);
    std::int64_t before = 0;  // faces of the earlier axes
    for (int a = 0; a < axis; ++a) {
      Vec3i n = cells_;
      n[a] -= 1;
      before += static_cast<std::int64_t>(n.x()) * n.y() * n.z();
    }
    Vec3i n = cells_;
    n[axis] -= 1;
    return 4 * (before + cell.x() +
                static_cast<std::int64_t>(n.x()) * (cell.y() + static_cast<std::int64_t>(n.y()) * cell.z())) +
           m;
  }

 private:
  // Face between two cubes: given by the lower cube along the axis.
  template <class F>
  void for_each_face(const F& f) const {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3i n = cells_;
      n[axis] -= 1;
      for (int k = 0; k < n.z(); ++k)
        for (int j = 0; j < n.y(); ++j)
          for (int i = 0; i < n.x(); ++i) f(Vec3i(i, j, k), axis);
    }
  }

  // Edge m of the face runs from its corner m to m + 1, around the axis: edges at v low, u high, v high, u low.
  Tetrahedron tet(const Vec3i& cell, int axis, int m) const {
    static constexpr int kU[4] = {0, 1, 1, 0}, kV[4] = {0, 0, 1, 1};
    const auto at = [&](int c) {
      Vec3i p = cell + Vec3i::Unit(axis);
      p[(axis + 1) % 3] += kU[c % 4];
      p[(axis + 2) % 3] += kV[c % 4];
      return corner(p);
    };
    return {center(cell), at(m), at(m + 1), center(cell + Vec3i::Unit(axis))};
  }

  Vec3 spacing_;
  Vec3i cells_;
  Vec3 origin_;
  std::int32_t corners_;
};

}  // namespace brim
