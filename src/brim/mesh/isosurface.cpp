#include "brim/mesh/isosurface.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "brim/core/error.h"
#include "brim/core/parallel.h"

namespace brim {

namespace {

// Corners of the six tetrahedra of a cube around its main diagonal, as bits x = 1, y = 2, z = 4; positive volume.
// Every edge goes from a corner to one that holds its bits too, so neighbouring cubes cut their faces alike.
constexpr int kTets[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

// Even orders of four corners that bring one corner, or a pair, to the front.
constexpr int kFront[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};
constexpr int kPairs[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};

using Key = std::uint64_t;  // lower node of a cut edge times 8, plus the bits of its direction
using KeyTriangle = std::array<Key, 3>;

// Adds the triangles of one tetrahedron; `inside` has a bit per corner.
template <class EdgeKey>
void march(unsigned inside, const EdgeKey& key, std::vector<KeyTriangle>& out) {
  for (int k = 0; k < 4; ++k) {
    const int* p = kFront[k];
    if (inside == 1u << k) {
      out.push_back({key(p[0], p[1]), key(p[0], p[2]), key(p[0], p[3])});
      return;
    }
    if (inside == (15u ^ (1u << k))) {
      out.push_back({key(p[0], p[1]), key(p[0], p[3]), key(p[0], p[2])});
      return;
    }
  }
  for (const auto& p : kPairs)
    if (inside == ((1u << p[0]) | (1u << p[1]))) {
      const Key ac = key(p[0], p[2]), ad = key(p[0], p[3]), bd = key(p[1], p[3]), bc = key(p[1], p[2]);
      out.push_back({ac, ad, bd});
      out.push_back({ac, bd, bc});
      return;
    }
}

}  // namespace

TriMesh isosurface(const ScalarLattice& g, const EdgeCut& cut) {
  const auto nx = static_cast<std::size_t>(g.nodes.x()), ny = static_cast<std::size_t>(g.nodes.y()),
             nz = static_cast<std::size_t>(g.nodes.z());
  BRIM_CHECK(g.values.size(), ==, nx * ny * nz);
  if (nx < 2 || ny < 2 || nz < 2) return {};
  std::array<std::size_t, 8> offset{};
  for (std::size_t c = 0; c < 8; ++c) offset[c] = (c & 1) + nx * ((c >> 1 & 1) + ny * (c >> 2));

  // Triangles of each layer of cubes, their corners still named by the edge they cut.
  std::vector<std::vector<KeyTriangle>> layers(nz - 1);
  parallel_for(nz - 1, [&](std::size_t k) {
    for (std::size_t j = 0; j + 1 < ny; ++j)
      for (std::size_t i = 0; i + 1 < nx; ++i) {
        const std::size_t base = i + nx * (j + ny * k);
        unsigned corners = 0;
        for (unsigned c = 0; c < 8; ++c) corners |= (g.values[base + offset[c]] < 0.0f ? 1u : 0u) << c;
        if (corners == 0 || corners == 255) continue;
        for (const auto& tet : kTets) {
          unsigned inside = 0;
          for (int c = 0; c < 4; ++c) inside |= (corners >> tet[c] & 1u) << c;
          const auto key = [&](int a, int b) {
            const auto low = static_cast<std::size_t>(std::min(tet[a], tet[b]));
            const auto high = static_cast<std::size_t>(std::max(tet[a], tet[b]));
            return static_cast<Key>((base + offset[low]) * 8 + (low ^ high));
          };
          march(inside, key, layers[k]);
        }
      }
  });

  std::vector<Key> keys;
  for (const auto& layer : layers)
    for (const KeyTriangle& t : layer) keys.insert(keys.end(), t.begin(), t.end());
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  TriMesh mesh;
  mesh.vertices.resize(keys.size());
  parallel_for(
      keys.size(),
      [&](std::size_t v) {
        const std::size_t a = keys[v] / 8, b = a + offset[keys[v] % 8];
        const auto position = [&](std::size_t n) {
          return Vec3(g.origin + g.spacing * Vec3(static_cast<double>(n % nx), static_cast<double>(n / nx % ny),
                                                  static_cast<double>(n / (nx * ny))));
        };
        const std::size_t in = g.values[a] < 0.0f ? a : b, out = in == a ? b : a;
        const Vec3 p = position(in), q = position(out);
        const double fp = g.values[in], fq = g.values[out];
        const double t = cut ? cut(p, q, fp, fq) : fp / (fp - fq);
        mesh.vertices[v] = p + std::clamp(t, 0.0, 1.0) * (q - p);
      },
      64);
  for (const auto& layer : layers)
    for (const KeyTriangle& t : layer) {
      Triangle corners;
      for (int c = 0; c < 3; ++c)
        corners[c] = static_cast<std::int32_t>(std::lower_bound(keys.begin(), keys.end(), t[c]) - keys.begin());
      mesh.triangles.push_back(corners);
    }
  return mesh;
}

}  // namespace brim
