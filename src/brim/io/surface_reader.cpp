#include "brim/io/surface_reader.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>

#include "brim/core/error.h"
#include "brim/io/assimp_format.h"
#include "brim/io/polygon_soup.h"
#include "brim/mesh/topology.h"

namespace brim {

namespace {

constexpr std::array<std::string_view, 6> kFormats = {".obj", ".stl", ".ply", ".off", ".gltf", ".glb"};

/// Triangles as the file has them, before equal vertices are joined.
TriMesh read_triangles(const std::filesystem::path& path, const std::string& extension) {
  const auto own = extension == ".obj"   ? read_obj
                   : extension == ".ply" ? read_ply
                   : extension == ".off" ? read_off
                                         : nullptr;
  if (own == nullptr) return read_by_assimp(path.string(), extension);
  PolygonSoup soup = own(path);
  return {std::move(soup.vertices), soup.triangles()};
}

}  // namespace

TriMesh read_surface(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) throw InputError(fmt::format("{}: no such file", name));
  if (!std::filesystem::is_regular_file(path, ignored)) throw InputError(fmt::format("{}: not a file", name));
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (std::find(kFormats.begin(), kFormats.end(), extension) == kFormats.end())
    throw InputError(
        fmt::format("{}: surfaces are read from {}, not from '{}' files", name, fmt::join(kFormats, " "), extension));
  if (std::filesystem::file_size(path, ignored) == 0) throw InputError(fmt::format("{}: the file is empty", name));

  return clean_surface(read_triangles(path, extension), name);
}

TriMesh clean_surface(TriMesh soup, const std::string& name) {
  // Single precision as in most formats: the same vertices are joined whatever the file. Volatile, for GCC 12 drops the
  // way there and back from vectorised loops.
  for (Vec3& x : soup.vertices)
    for (double& number : x) {
      const volatile float single = static_cast<float>(number);
      number = static_cast<double>(single);
    }
  if (soup.triangles.empty()) throw InputError(fmt::format("{}: the file holds no triangles", name));
  for (std::size_t v = 0; v < soup.vertices.size(); ++v)
    if (!soup.vertices[v].allFinite())
      throw InputError(fmt::format("{}: a vertex is not finite: ({}, {}, {})", name, soup.vertices[v].x(),
                                   soup.vertices[v].y(), soup.vertices[v].z()));
  for (const Triangle& t : soup.triangles)
    for (const std::int32_t v : t)
      if (v < 0 || static_cast<std::size_t>(v) >= soup.vertices.size())
        throw InputError(fmt::format("{}: a triangle names a vertex that does not exist", name));
  TriMesh mesh = weld(soup, 0.0);
  if (inspect(mesh).degenerate_triangles == mesh.triangles.size())
    throw InputError(fmt::format("{}: all {} triangles have no area", name, soup.triangles.size()));
  return mesh;
}

}  // namespace brim
