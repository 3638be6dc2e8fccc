#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Polygons of a file as triangles, before equal vertices are merged.
class PolygonSoup {
 public:
  static constexpr std::size_t kMostCorners = 1000;  ///< of a polygon: triangulation costs their square or cube

  std::vector<Vec3> vertices;  ///< [m]
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /// Triangulates a polygon: a convex one as a fan, others by ear clipping. Fewer than three corners add nothing.
  /// @param corners  existing vertices, at most kMostCorners
  void add(std::span<const std::int32_t> corners);

 private:
  void cut_ears(std::vector<std::int32_t> corners, const Vec3& normal);
  std::vector<Triangle> triangles_;
};

/// Polygon formats parsed by brim itself: counts are checked before memory is allocated, and every index before it is
/// used (docs/dependencies.md gives the reasons). Faces need three corners or more.
/// @throws InputError  with the path, the position and the reason
/// Tests: tests/io/polygon_formats_test.cpp
PolygonSoup read_obj(const std::filesystem::path& path);  ///< positions and faces; the rest is ignored
PolygonSoup read_ply(const std::filesystem::path& path);  ///< text and both binary forms
PolygonSoup read_off(const std::filesystem::path& path);  ///< text; colours, normals and textures are ignored

}  // namespace brim
