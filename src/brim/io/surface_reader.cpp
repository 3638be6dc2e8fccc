#include "brim/io/surface_reader.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cctype>
#include <string>
#include <string_view>

#include "brim/core/error.h"
#include "brim/io/polygon_soup.h"
#include "brim/mesh/topology.h"

namespace brim {

namespace {

constexpr std::array<std::string_view, 6> kFormats = {".obj", ".stl", ".ply", ".off", ".gltf", ".glb"};

// Adds the triangles of a node and of its children, moved by all transforms above them.
void add_node(const aiScene& scene, const aiNode& node, const aiMatrix4x4& above, TriMesh& out) {
  const aiMatrix4x4 placed = above * node.mTransformation;
  // A mirroring transform turns triangles inside out.
  const bool mirrored = aiMatrix3x3(placed).Determinant() < 0;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    const auto shift = static_cast<std::int32_t>(out.vertices.size());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D p = placed * mesh.mVertices[v];
      out.vertices.emplace_back(p.x, p.y, p.z);
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;
      Triangle t;
      for (int k = 0; k < 3; ++k) t[k] = shift + static_cast<std::int32_t>(face.mIndices[k]);
      if (mirrored) std::swap(t[1], t[2]);
      out.triangles.push_back(t);
    }
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) add_node(scene, *node.mChildren[c], placed, out);
}

TriMesh read_by_assimp(const std::string& name, const std::string& extension) {
  Assimp::Importer importer;
  // Positions only: whatever else differs between two vertices must not keep them apart.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
                                  aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
                                  aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene =
      importer.ReadFile(name, aiProcess_RemoveComponent | aiProcess_Triangulate | aiProcess_SortByPType);
  if (!scene || !scene->mRootNode)
    throw InputError(
        fmt::format("{}: not a readable {} mesh ({})", name, extension.substr(1), importer.GetErrorString()));

  TriMesh soup;
  add_node(*scene, *scene->mRootNode, aiMatrix4x4(), soup);
  return soup;
}

/// Triangles as the file has them, before equal vertices are joined.
TriMesh read_triangles(const std::filesystem::path& path, const std::string& extension) {
  if (extension != ".ply" && extension != ".off") return read_by_assimp(path.string(), extension);
  PolygonSoup soup = extension == ".ply" ? read_ply(path) : read_off(path);
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
