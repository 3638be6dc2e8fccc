#include "brim/mesh/voxel_image.h"

#include <algorithm>

namespace brim {

Aabb VoxelImage::box() const {
  Aabb b;
  for (int c = 0; c < 8; ++c) {
    Vec3 index;
    for (int a = 0; a < 3; ++a) index[a] = (c >> a & 1) != 0 ? size[a] - 0.5 : -0.5;
    b.extend(origin + axes * index);
  }
  return b;
}

bool VoxelImage::sample(const Vec3& index, double& value) const {
  int i[3];
  double t[3];
  std::size_t step[3] = {1, static_cast<std::size_t>(size.x()), static_cast<std::size_t>(size.x()) * size.y()};
  for (int a = 0; a < 3; ++a) {
    const double x = index[a];
    if (!(x >= -0.5 && x <= size[a] - 0.5)) return false;
    const double c = std::clamp(x, 0.0, size[a] - 1.0);
    i[a] = std::min(static_cast<int>(c), std::max(0, size[a] - 2));
    t[a] = c - i[a];
    if (size[a] == 1) step[a] = 0;
  }
  const float* v =
      values.data() + i[0] + static_cast<std::size_t>(size.x()) * (i[1] + static_cast<std::size_t>(size.y()) * i[2]);
  const auto line = [&](const float* p) { return p[0] + t[0] * (p[step[0]] - p[0]); };
  const auto face = [&](const float* p) { return line(p) + t[1] * (line(p + step[1]) - line(p)); };
  const double near = face(v);
  value = near + t[2] * (face(v + step[2]) - near);
  return true;
}

}  // namespace brim
