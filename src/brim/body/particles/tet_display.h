#pragma once

#include "brim/body/body.h"

namespace brim {

/// Display of a body of tetrahedra: its boundary, or a fine surface carried by the elements.
class TetDisplay {
 public:
  /// @param boundary  boundary triangles of the mesh, indices into its vertices
  /// @param fine      rest shape in the mesh's frame, or without triangles: show the boundary
  TetDisplay(const TetMesh& mesh, std::span<const Triangle> boundary, const TriMesh& fine);

  const Display& display() const { return display_; }
  /// @param x  positions of the mesh's vertices, [m]  @param out  shape (display().vertices)
  void positions(std::span<const Vec3> x, std::span<Vec3f> out) const;
  /// @param value  at the mesh's vertices  @param out  shape (display().vertices)
  void values(std::span<const double> value, std::span<float> out) const;

 private:
  Display display_;
  std::vector<std::array<std::int32_t, 4>> carrier_;  // vertices that carry each display vertex
  std::vector<std::array<double, 4>> weight_;
};

}  // namespace brim
