#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace brim {

/// The triangles of a sheet and the patch around each, all triangles that share a vertex with it: points are attached
/// to the patch where the triangle alone is too small or too distorted (ShellWeightsMap).
class SheetPatches {
 public:
  using Corners = std::array<std::int32_t, 3>;

  /// @param triangles  vertices of each, shape (triangles)
  explicit SheetPatches(std::span<const Corners> triangles);

  const Corners& triangle(std::size_t t) const { return triangles_[t]; }
  /// Vertices of the patch around triangle t, ascending, its own included.
  std::span<const std::int32_t> around(std::size_t t) const {
    return std::span(vertices_).subspan(first_[t], static_cast<std::size_t>(first_[t + 1] - first_[t]));
  }

 private:
  std::vector<Corners> triangles_;
  std::vector<std::int32_t> first_, vertices_;
};

}  // namespace brim
