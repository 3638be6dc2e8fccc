#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Polygons of a file as triangles, before equal vertices are joined.
class PolygonSoup {
 public:
  static constexpr std::size_t kMostCorners = 1000;  ///< of a polygon: splitting one costs their square or cube

  std::vector<Vec3> vertices;  ///< [m]
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /// Splits a polygon: a convex one into a fan, any other by cutting off ears. Fewer than three corners add nothing.
  /// @param corners  vertices that exist, at most kMostCorners
  void add(std::span<const std::int32_t> corners);

 private:
  void cut_ears(std::vector<std::int32_t> corners, const Vec3& normal);
  std::vector<Triangle> triangles_;
};

/// Polygon files read by brim itself: what they say is checked before memory is taken for it, and every index before it
/// is used (docs/dependencies.md says why they are not left to a library). Faces need three corners or more.
/// @throws InputError  with the path, the place and the reason
/// Tests: tests/io/polygon_formats_test.cpp
PolygonSoup read_obj(const std::filesystem::path& path);  ///< positions and faces; all else is passed over
PolygonSoup read_ply(const std::filesystem::path& path);  ///< text and both binary forms
PolygonSoup read_off(const std::filesystem::path& path);  ///< text; colours, normals and textures are passed over

}  // namespace brim
