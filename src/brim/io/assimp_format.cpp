#include "brim/io/assimp_format.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>

#include "brim/core/error.h"
#include "brim/io/child_reader.h"

namespace brim {

namespace {

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

TriMesh read_here(const std::string& name, const std::string& extension) {
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

}  // namespace

TriMesh read_by_assimp(const std::string& path, const std::string& extension) {
  ChildReader reader(path, [&](int, ChildReader::Answer& answer) {
    const TriMesh mesh = read_here(path, extension);
    answer.put_list(mesh.vertices);
    answer.put_list(mesh.triangles);
  });
  ChildReader::Received received = reader.ask(0);
  TriMesh mesh;
  mesh.vertices = received.get_list<Vec3>();
  mesh.triangles = received.get_list<Triangle>();
  return mesh;
}

}  // namespace brim
