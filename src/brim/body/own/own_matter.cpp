#include "brim/body/own/own_matter.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "brim/mesh/mass_properties.h"
#include "brim/mesh/tet_lattice.h"
#include "brim/mesh/tet_moments.h"

namespace brim {

namespace {

/// S^power of a symmetric matrix that is not negative.
Mat3 power_of(const Mat3& S, double power) {
  const Eigen::SelfAdjointEigenSolver<Mat3> e(0.5 * (S + S.transpose()));
  const Vec3 values = e.eigenvalues().cwiseMax(0.0).array().pow(power);
  return e.eigenvectors() * values.asDiagonal() * e.eigenvectors().transpose();
}

}  // namespace

MassPoints mass_points(const TriMesh& surface, double density, double spacing) {
  const MassProperties whole = mass_properties(surface, density);
  const TetMesh tets = tet_lattice(surface, spacing);
  // About the centre, where rounding is least; cells in the order of their place.
  std::map<std::array<std::int64_t, 3>, TetMoments> cells;
  TetMoments all;
  for (const Tetrahedron& t : tets.tets) {
    std::array<Vec3, 4> x;
    for (int k = 0; k < 4; ++k) x[k] = tets.vertices[t[k]] - whole.center;
    const Vec3 middle = 0.25 * (x[0] + x[1] + x[2] + x[3]) / spacing;
    std::array<std::int64_t, 3> cell;
    for (int k = 0; k < 3; ++k) cell[k] = static_cast<std::int64_t>(std::floor(middle[k]));
    const double det = 6.0 * tet_volume(x[0], x[1], x[2], x[3]);
    cells[cell].add(det, x[0], x[1], x[2], x[3]);
    all.add(det, x[0], x[1], x[2], x[3]);
  }
  const Mat3 variance = (0.5 * whole.inertia.trace() * Mat3::Identity() - whole.inertia) / whole.mass;
  const Mat3 root = power_of(all.variance(), 0.5), back = power_of(all.variance(), -0.5);
  const Mat3 A = back * power_of(root * variance * root, 0.5) * back;
  static const std::array<Vec3, 4> kSpread = {Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)};
  MassPoints points;
  for (const auto& [cell, m] : cells) {
    if (!(m.volume > 0.0)) continue;
    const Mat3 spread = power_of(m.variance(), 0.5);
    for (const Vec3& s : kSpread) {
      points.at.push_back(whole.center + A * (m.center() + spread * s - all.center()));
      points.mass.push_back(0.25 * whole.mass * m.volume / all.volume);
    }
  }
  return points;
}

TriMesh with_short_edges(const TriMesh& surface, double longest) {
  TriMesh mesh = surface;
  for (bool split = true; split;) {
    split = false;
    std::map<std::array<std::int32_t, 2>, std::int32_t> middle;
    // The vertex in the middle of an edge that is too long, or -1.
    const auto middle_of = [&](std::int32_t a, std::int32_t b) {
      const Vec3 &x = mesh.vertices[a], &y = mesh.vertices[b];
      if (!((x - y).norm() > longest)) return -1;
      const auto [at, added] = middle.try_emplace({std::min(a, b), std::max(a, b)}, mesh.vertices.size());
      if (added) mesh.vertices.push_back(Vec3(0.5 * (x + y)));
      return at->second;
    };
    std::vector<Triangle> triangles;
    for (const Triangle& t : mesh.triangles) {
      const std::array<std::int32_t, 3> m = {middle_of(t[0], t[1]), middle_of(t[1], t[2]), middle_of(t[2], t[0])};
      const auto cut = std::count_if(m.begin(), m.end(), [](std::int32_t i) { return i >= 0; });
      split = split || cut > 0;
      if (cut == 0) {
        triangles.push_back(t);
      } else if (cut == 3) {
        for (int k = 0; k < 3; ++k) triangles.push_back({t[k], m[k], m[(k + 2) % 3]});
        triangles.push_back({m[0], m[1], m[2]});
      } else {
        // From an edge that is cut, the next of which is not where only two are.
        int k = 0;
        while (m[k] < 0 || (cut == 2 && m[(k + 1) % 3] >= 0)) ++k;
        const std::int32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3], ab = m[k], ca = m[(k + 2) % 3];
        triangles.push_back({ab, b, c});
        if (ca < 0) {
          triangles.push_back({a, ab, c});
        } else {
          triangles.push_back({a, ab, ca});
          triangles.push_back({ab, c, ca});
        }
      }
    }
    mesh.triangles = std::move(triangles);
  }
  return mesh;
}

}  // namespace brim
