#include <cstring>
#include <map>

#include "brim/body/changing_surface.h"
#include "brim/body/posed_display.h"
#include "brim/record/packed.h"
#include "brim/record/run_layout.h"
#include "brim/record/run_tables.h"

namespace brim {

using h5::Type;

namespace {

/// Meshes of pieces, each distinct one once: a pile of equal boxes has one.
class MeshStore {
 public:
  std::int32_t add(const TriMesh& mesh) {
    const auto [place, fresh] = shared_.try_emplace(&mesh, -1);
    if (fresh) place->second = find(mesh);
    return place->second;
  }
  Packed<Vec3> vertices;
  Packed<Triangle> triangles;

 private:
  /// The mesh that has the same numbers, or a new one.
  std::int32_t find(const TriMesh& mesh) {
    const auto [from, to] = known_.equal_range(mark(mesh));
    for (auto it = from; it != to; ++it)
      if (same(static_cast<std::size_t>(it->second), mesh)) return it->second;
    const auto index = static_cast<std::int32_t>(vertices.first.size()) - 1;
    vertices.add(mesh.vertices);
    triangles.add(mesh.triangles);
    known_.emplace(mark(mesh), index);
    return index;
  }
  static std::uint64_t mark(const TriMesh& mesh) {
    std::uint64_t h = mesh.vertices.size() * 0x9e3779b97f4a7c15u + mesh.triangles.size();
    for (const Vec3& x : mesh.vertices)
      for (int a = 0; a < 3; ++a) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &x[a], sizeof bits);
        h = (h ^ bits) * 0x100000001b3u;
        h ^= h >> 29;
      }
    return h;
  }
  bool same(std::size_t i, const TriMesh& mesh) const {
    return std::ranges::equal(vertices.at(i), mesh.vertices) && std::ranges::equal(triangles.at(i), mesh.triangles);
  }
  std::multimap<std::uint64_t, std::int32_t> known_;
  std::map<const TriMesh*, std::int32_t> shared_;  ///< those that bodies share, by where they lie
};

/// The body's pieces where they are all of its display: the same vertices and triangles in the same order.
const PosedDisplay* whole_posed(const Body& body) {
  const PosedDisplay* posed = posed_display(body);
  if (posed == nullptr || body.display().kind != Display::Kind::Triangles) return nullptr;
  const SharedList<Triangle>& wanted = body.display().triangles;
  if (posed->piece_count() == 1 && wanted.data() == posed->piece(0).surface().triangles.data())
    return body.display().vertices == posed->piece(0).surface().vertices.size() ? posed : nullptr;
  std::size_t vertices = 0, triangles = 0;
  for (std::size_t i = 0; i < posed->piece_count(); ++i) {
    const TriMesh& mesh = posed->piece(i).surface();
    const auto shift = static_cast<std::int32_t>(vertices);
    if (mesh.triangles.size() > wanted.size() - triangles) return nullptr;
    for (const Triangle& t : mesh.triangles)
      if (wanted[triangles++] != Triangle{t[0] + shift, t[1] + shift, t[2] + shift}) return nullptr;
    vertices += mesh.vertices.size();
  }
  return vertices == body.display().vertices && triangles == wanted.size() ? posed : nullptr;
}

template <class T>
void write_column(h5::File& file, const std::string& path, Type type, const std::vector<T>& values,
                  std::uint64_t width = 0) {
  const std::uint64_t rows =
      width > 0 ? values.size() * sizeof(T) / (width * (type == Type::Int32 ? 4 : 8)) : values.size();
  file.write(path, type, width > 0 ? std::vector<std::uint64_t>{rows, width} : std::vector<std::uint64_t>{rows},
             values.data());
}

void write_parts(h5::File& file, const World& world) {
  std::vector<std::string> name, material;
  std::vector<std::int64_t> body, index;
  std::vector<double> voxel_size;
  for (int p = 0; p < world.part_count(); ++p) {
    const PartRef ref = world.part(p);
    const Body& owner = world.body(ref.body);
    const PartInfo part = owner.part(ref.index);
    name.push_back(owner.part_count() > 1 ? fmt::format("{}/{}", owner.name(), ref.index) : owner.name());
    material.push_back(part.material.name);
    body.push_back(ref.body);
    index.push_back(ref.index);
    voxel_size.push_back(part.voxel_size);
  }
  file.group("/parts");
  file.write_texts("/parts/name", name);
  file.write_texts("/parts/material", material);
  write_column(file, "/parts/body", Type::Int64, body);
  write_column(file, "/parts/part", Type::Int64, index);
  write_column(file, "/parts/voxel_size", Type::Float64, voxel_size);
}

}  // namespace

void write_tables(h5::File& file, const World& world) {
  std::vector<std::string> name, kind, display_kind;
  std::map<std::string, std::vector<std::int64_t>> whole;
  std::vector<double> mass, radius;
  MeshStore meshes;
  Packed<Triangle> triangles;
  Packed<std::array<std::int32_t, 2>> lines;
  std::vector<std::int32_t> piece_body, piece_mesh;
  std::int64_t q_offset = 0, v_offset = 0, positions = 0;
  for (int b = 0; b < world.body_count(); ++b) {
    const Body& body = world.body(b);
    const Display& d = body.display();
    const bool changing = changing_surface(body) != nullptr;
    const PosedDisplay* posed = whole_posed(body);
    name.push_back(body.name());
    kind.emplace_back(body.kind());
    display_kind.emplace_back(run_layout::display_word(d.kind));
    mass.push_back(body.mass());
    radius.push_back(d.radius);
    const auto put = [&](const char* column, auto value) { whole[column].push_back(static_cast<std::int64_t>(value)); };
    put("two_sided", d.two_sided);
    put("vertices", d.vertices);
    put("changing", changing);
    put("immobile", body.immobile());
    put("still", body.immobile() && !changing);
    put("q_offset", q_offset);
    put("q_size", body.q_size());
    put("v_offset", v_offset);
    put("v_size", body.v_size());
    put("parts", body.part_count());
    put("pieces", posed != nullptr ? posed->piece_count() : 0);
    put("first_position", posed != nullptr || changing ? -1 : positions);
    if (posed != nullptr) {
      for (std::size_t i = 0; i < posed->piece_count(); ++i) {
        piece_body.push_back(b);
        piece_mesh.push_back(meshes.add(posed->piece(i).surface()));
      }
      triangles.add({});
    } else {
      triangles.add(changing ? std::span<const Triangle>() : std::span(d.triangles));
      if (!changing) positions += static_cast<std::int64_t>(d.vertices);
    }
    lines.add(d.lines);
    q_offset += static_cast<std::int64_t>(body.q_size());
    v_offset += static_cast<std::int64_t>(body.v_size());
  }
  for (const char* group : {"/bodies", "/display", "/meshes", "/poses"}) file.group(group);
  file.write_texts("/bodies/name", name);
  file.write_texts("/bodies/kind", kind);
  file.write_texts("/bodies/display_kind", display_kind);
  write_column(file, "/bodies/mass", Type::Float64, mass);
  write_column(file, "/bodies/radius", Type::Float64, radius);
  for (const auto& [column, values] : whole) write_column(file, "/bodies/" + column, Type::Int64, values);
  write_column(file, "/display/triangles", Type::Int32, triangles.items, 3);
  write_column(file, "/display/first_triangle", Type::Int64, triangles.first);
  write_column(file, "/display/lines", Type::Int32, lines.items, 2);
  write_column(file, "/display/first_line", Type::Int64, lines.first);
  write_column(file, "/meshes/vertices", Type::Float64, meshes.vertices.items, 3);
  write_column(file, "/meshes/first_vertex", Type::Int64, meshes.vertices.first);
  write_column(file, "/meshes/triangles", Type::Int32, meshes.triangles.items, 3);
  write_column(file, "/meshes/first_triangle", Type::Int64, meshes.triangles.first);
  write_column(file, "/poses/body", Type::Int32, piece_body);
  write_column(file, "/poses/mesh", Type::Int32, piece_mesh);
  write_parts(file, world);
}

}  // namespace brim
