#pragma once

#include <map>
#include <random>
#include <set>
#include <vector>

#include "brim/mesh/tri_mesh.h"

namespace brim::testing {

/// Block of nx × ny × nz cells of side `cell`, six tetrahedra each around the main diagonal; node (i, j, k) has index
/// i + (nx + 1) (j + (ny + 1) k).
inline TetMesh block(int nx, int ny, int nz, double cell) {
  TetMesh mesh;
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) mesh.vertices.push_back(cell * Vec3(i, j, k));
  const auto at = [&](int i, int j, int k) { return i + (nx + 1) * (j + (ny + 1) * k); };
  constexpr int kOrder[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (int o = 0; o < 6; ++o) {
          int c[3] = {i, j, k};
          Tetrahedron t{};
          t[0] = at(c[0], c[1], c[2]);
          for (int s = 0; s < 3; ++s) {
            ++c[kOrder[o][s]];
            t[s + 1] = at(c[0], c[1], c[2]);
          }
          if (o >= 3) std::swap(t[2], t[3]);
          mesh.tets.push_back(t);
        }
  return mesh;
}

/// Faces that only one tetrahedron has, outwards, and that tetrahedron.
struct Boundary {
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> owner;
};
inline Boundary boundary(const TetMesh& mesh) {
  std::map<std::set<std::int32_t>, std::pair<Triangle, std::pair<int, int>>> faces;
  constexpr int kFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (const auto& f : kFace) {
      const Triangle t = {mesh.tets[e][f[0]], mesh.tets[e][f[1]], mesh.tets[e][f[2]]};
      auto& entry = faces[{t[0], t[1], t[2]}];
      entry.first = t;
      entry.second.first = static_cast<int>(e);
      ++entry.second.second;
    }
  Boundary b;
  for (const auto& [key, face] : faces)
    if (face.second.second == 1) {
      b.triangles.push_back(face.first);
      b.owner.push_back(face.second.first);
    }
  return b;
}

inline double segment_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double l2 = (b - a).squaredNorm();
  const double t = l2 > 0 ? std::clamp((p - a).dot(b - a) / l2, 0.0, 1.0) : 0.0;
  return (p - a - t * (b - a)).norm();
}

/// Distance to a triangle: to its plane where the foot is inside, else to its edges.
inline double triangle_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 m = (b - a).cross(c - a);
  const double m2 = m.squaredNorm();
  if (m2 > 0) {
    const Vec3 foot = p - m * (m.dot(p - a) / m2);
    if ((b - a).cross(foot - a).dot(m) >= 0 && (c - b).cross(foot - b).dot(m) >= 0 &&
        (a - c).cross(foot - c).dot(m) >= 0)
      return (foot - p).norm();
  }
  return std::min({segment_distance(p, a, b), segment_distance(p, b, c), segment_distance(p, c, a)});
}

/// Deterministic noise for positions.
class Noise {
 public:
  explicit Noise(unsigned seed) : rng_(seed) {}
  double operator()() { return uniform_(rng_); }
  Vec3 vec() { return Vec3((*this)(), (*this)(), (*this)()); }

 private:
  std::mt19937 rng_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

}  // namespace brim::testing
