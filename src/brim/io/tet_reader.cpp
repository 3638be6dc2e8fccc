#include "brim/io/tet_reader.h"

#include <algorithm>
#include <cctype>
#include <limits>
#include <string>

#include "brim/core/error.h"
#include "brim/io/tet_formats.h"
#include "brim/mesh/mass_properties.h"

namespace brim {

namespace {

[[noreturn]] void fail(const std::string& name, const std::string& reason) {
  throw InputError(fmt::format("{}: {}", name, reason));
}

// Only the vertices that a tetrahedron uses, in the order of the file.
TetMesh without_unused(const std::string& name, const RawTets& raw) {
  const auto n = static_cast<std::int64_t>(raw.points.size());
  std::vector<std::int32_t> number(raw.points.size(), -1);
  for (std::size_t e = 0; e < raw.tets.size(); ++e)
    for (const std::int64_t v : raw.tets[e]) {
      if (v < 0 || v >= n) fail(name, fmt::format("tetrahedron {} names vertex {}, but there are {}", e, v, n));
      number[static_cast<std::size_t>(v)] = 0;
    }
  TetMesh mesh;
  for (std::size_t v = 0; v < raw.points.size(); ++v) {
    if (number[v] < 0) continue;
    const Vec3& x = raw.points[v];
    if (!x.allFinite()) fail(name, fmt::format("vertex {} is not finite: ({}, {}, {})", v, x.x(), x.y(), x.z()));
    number[v] = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.push_back(x);
  }
  mesh.tets.reserve(raw.tets.size());
  for (const auto& t : raw.tets) mesh.tets.push_back({number[t[0]], number[t[1]], number[t[2]], number[t[3]]});
  return mesh;
}

// Turns a mesh that is inside out as a whole; refuses one that is so in part, or has flat tetrahedra.
void orient(const std::string& name, TetMesh& mesh) {
  std::size_t inverted = 0, flat = 0, first_inverted = 0, first_flat = 0;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const Tetrahedron& t = mesh.tets[e];
    double longest = 0.0;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) longest = std::max(longest, (mesh.vertices[t[i]] - mesh.vertices[t[j]]).norm());
    const double v = tet_volume(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], mesh.vertices[t[3]]);
    if (!(std::abs(v) > 1e-14 * longest * longest * longest)) {
      if (flat++ == 0) first_flat = e;
    } else if (v < 0.0) {
      if (inverted++ == 0) first_inverted = e;
    }
  }
  if (flat > 0)
    fail(name, fmt::format("{} of {} tetrahedra are flat, the first is number {} (from 0)", flat, mesh.tets.size(),
                           first_flat));
  if (inverted == mesh.tets.size()) {
    for (Tetrahedron& t : mesh.tets) std::swap(t[2], t[3]);
  } else if (inverted > 0) {
    fail(name, fmt::format("{} of {} tetrahedra are inverted, the first is number {} (from 0)", inverted,
                           mesh.tets.size(), first_inverted));
  }
}

}  // namespace

TetMesh read_tets(const std::filesystem::path& path) {
  FileCursor file(path);
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".msh" && extension != ".vtk")
    file.fail(fmt::format("tetrahedra are read from .msh and .vtk files, not from '{}' files", extension));
  const RawTets raw = extension == ".msh" ? parse_gmsh(file) : parse_vtk(file);
  if (raw.tets.empty()) file.fail("the file holds no tetrahedra");
  if (raw.points.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    file.fail(fmt::format("{} vertices are more than can be counted", raw.points.size()));
  TetMesh mesh = without_unused(path.string(), raw);
  orient(path.string(), mesh);
  return mesh;
}

TetMesh clean_tets(const TetMesh& given, const std::string& name) {
  RawTets raw{given.vertices, {}};
  for (const Tetrahedron& t : given.tets) raw.tets.push_back({t[0], t[1], t[2], t[3]});
  if (raw.tets.empty()) fail(name, "there are no tetrahedra");
  TetMesh mesh = without_unused(name, raw);
  orient(name, mesh);
  return mesh;
}

}  // namespace brim
