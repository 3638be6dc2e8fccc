#include <utility>

#include "brim/mesh/topology.h"
#include "brim/mesh/triangle_sides.h"

namespace brim {

TriMesh oriented_outwards(const TriMesh& mesh) {
  const std::vector<Side> sides = sorted_sides(mesh.triangles);
  const std::size_t n = mesh.triangles.size();
  std::vector<std::vector<std::pair<std::int32_t, bool>>> neighbours(n);
  for_each_edge(sides, [&](const Side* first, const Side* last) {
    if (last - first != 2) return;
    const bool same = first[0].forward != first[1].forward;
    neighbours[first[0].triangle].push_back({first[1].triangle, same});
    neighbours[first[1].triangle].push_back({first[0].triangle, same});
  });

  // Each patch connected through ordinary edges gets one sense, then the patch as a whole is turned.
  TriMesh result = mesh;
  std::vector<std::int8_t> sense(n, 0);
  for (std::size_t seed = 0; seed < n; ++seed) {
    if (sense[seed] != 0) continue;
    std::vector<std::int32_t> patch = {static_cast<std::int32_t>(seed)};
    sense[seed] = 1;
    for (std::size_t i = 0; i < patch.size(); ++i)
      for (const auto& [t, same] : neighbours[patch[i]])
        if (sense[t] == 0) {
          sense[t] = same ? sense[patch[i]] : static_cast<std::int8_t>(-sense[patch[i]]);
          patch.push_back(t);
        }
    std::vector<Triangle> as_turned;
    std::ptrdiff_t kept = 0;
    const Vec3 o = mesh.vertices[mesh.triangles[seed][0]];
    double volume = 0.0;
    for (const std::int32_t t : patch) {
      Triangle c = mesh.triangles[t];
      if (sense[t] < 0) std::swap(c[1], c[2]);
      kept += sense[t];
      volume += (mesh.vertices[c[0]] - o).cross(mesh.vertices[c[1]] - o).dot(mesh.vertices[c[2]] - o);
      as_turned.push_back(c);
    }
    const bool open = !boundary_edges(as_turned).empty();
    const bool turn = open ? kept < 0 : volume < 0.0;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      if (turn) std::swap(as_turned[i][1], as_turned[i][2]);
      result.triangles[patch[i]] = as_turned[i];
    }
  }
  return result;
}

}  // namespace brim
