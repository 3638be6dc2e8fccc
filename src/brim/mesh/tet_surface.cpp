#include <algorithm>
#include <tuple>

#include "brim/mesh/topology.h"

namespace brim {

TetSurface tet_surface(const TetMesh& mesh) {
  // Faces of a tetrahedron with positive volume, counter-clockwise from outside.
  static constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  struct Face {
    Triangle sorted, corners;
    std::int32_t tet;
  };
  std::vector<Face> faces;
  faces.reserve(4 * mesh.tets.size());
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (const auto& f : kFaces) {
      const Triangle c = {mesh.tets[e][f[0]], mesh.tets[e][f[1]], mesh.tets[e][f[2]]};
      Triangle s = c;
      std::sort(s.begin(), s.end());
      faces.push_back({s, c, static_cast<std::int32_t>(e)});
    }
  std::sort(faces.begin(), faces.end(),
            [](const Face& x, const Face& y) { return std::tie(x.sorted, x.tet) < std::tie(y.sorted, y.tet); });
  std::vector<Face> outer;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t j = i + 1;
    while (j < faces.size() && faces[j].sorted == faces[i].sorted) ++j;
    if (j - i == 1) outer.push_back(faces[i]);
    i = j;
  }
  std::sort(outer.begin(), outer.end(),
            [](const Face& x, const Face& y) { return std::tie(x.tet, x.sorted) < std::tie(y.tet, y.sorted); });
  TetSurface surface;
  for (const Face& f : outer) {
    surface.triangles.push_back(f.corners);
    surface.owner.push_back(f.tet);
  }
  return surface;
}

}  // namespace brim
