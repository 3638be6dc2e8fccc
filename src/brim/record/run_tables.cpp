#include "brim/record/run_tables.h"

#include "brim/record/run_layout.h"
#include "brim/record/table_columns.h"

namespace brim {

using h5::Type;

namespace {

constexpr std::int64_t kMost = std::int64_t{1} << 40;  ///< of anything that is counted

std::vector<RecordedPart> read_parts(const h5::File& file, std::size_t bodies) {
  const std::vector<std::string> name = file.read_texts("/parts/name");
  const std::vector<std::string> material = read_names(file, "/parts/material", name.size());
  const auto body = read_whole(file, "/parts/body", name.size(), 0, static_cast<std::int64_t>(bodies) - 1);
  const auto part = read_whole(file, "/parts/part", name.size(), 0, run_layout::kMostParts);
  const std::vector<double> voxel = read_real(file, "/parts/voxel_size", name.size());
  std::vector<RecordedPart> parts;
  for (std::size_t p = 0; p < name.size(); ++p)
    parts.push_back({name[p], material[p], static_cast<int>(body[p]), static_cast<int>(part[p]), voxel[p]});
  return parts;
}

}  // namespace

RunTables read_tables(const h5::File& file) {
  RunTables t;
  const std::vector<std::string> name = file.read_texts("/bodies/name");
  const std::size_t n = name.size();
  const std::vector<std::string> kind = read_names(file, "/bodies/kind", n);
  const std::vector<std::string> display_kind = read_names(file, "/bodies/display_kind", n);
  const std::vector<double> mass = read_real(file, "/bodies/mass", n), radius = read_real(file, "/bodies/radius", n);
  const auto whole = [&](const char* column, std::int64_t least, std::int64_t most) {
    return read_whole(file, std::string("/bodies/") + column, n, least, most);
  };
  const auto two_sided = whole("two_sided", 0, 1), vertices = whole("vertices", 0, kMost),
             changing = whole("changing", 0, 1), immobile = whole("immobile", 0, 1),
             q_offset = whole("q_offset", 0, kMost), q_size = whole("q_size", 0, kMost),
             v_offset = whole("v_offset", 0, kMost), v_size = whole("v_size", 0, kMost),
             parts = whole("parts", 0, run_layout::kMostParts), pieces = whole("pieces", 0, run_layout::kMostParts),
             first_position = whole("first_position", -1, kMost);
  const auto triangles = read_packed<Triangle>(file, "/display/triangles", Type::Int32, 3, "/display/first_triangle");
  const auto lines =
      read_packed<std::array<std::int32_t, 2>>(file, "/display/lines", Type::Int32, 2, "/display/first_line");
  auto meshes = read_packed<Vec3>(file, "/meshes/vertices", Type::Float64, 3, "/meshes/first_vertex");
  const auto mesh_triangles =
      read_packed<Triangle>(file, "/meshes/triangles", Type::Int32, 3, "/meshes/first_triangle");
  if (mesh_triangles.first.size() != meshes.first.size())
    throw InputError(file.path() + ":/meshes: the lists of vertices and of triangles must be of equally many meshes");
  const auto mesh_count = static_cast<std::int32_t>(meshes.first.size()) - 1;
  for (std::int32_t m = 0; m < mesh_count; ++m)
    check_indices(file, mesh_triangles.at(static_cast<std::size_t>(m)), meshes.at(static_cast<std::size_t>(m)).size(),
                  "/meshes/triangles");
  t.piece_mesh = read_column<std::int32_t>(file, "/poses/mesh", Type::Int32);
  for (const std::int32_t m : t.piece_mesh)
    if (m < 0 || m >= mesh_count)
      throw InputError(
          fmt::format("{}:/poses/mesh: names mesh {}; it must be from 0 to {}", file.path(), m, mesh_count - 1));
  t.rest = std::move(meshes.items);
  t.mesh_first_vertex = std::move(meshes.first);
  for (const auto& [list, what] :
       {std::pair(&triangles.first, "/display/first_triangle"), std::pair(&lines.first, "/display/first_line")})
    if (list->size() != n + 1) throw InputError(fmt::format("{}:{}: must have {} rows", file.path(), what, n + 1));

  std::size_t first_piece = 0;
  std::vector<SharedList<Triangle>> whole_mesh(static_cast<std::size_t>(mesh_count));
  for (std::size_t b = 0; b < n; ++b) {
    RecordedBody body;
    body.name = name[b];
    body.kind = kind[b];
    body.display.kind = run_layout::display_kind(display_kind[b], file.path());
    body.display.two_sided = two_sided[b] != 0;
    body.display.radius = radius[b];
    body.display.vertices = static_cast<std::size_t>(vertices[b]);
    body.immobile = immobile[b] != 0;
    body.changing = changing[b] != 0;
    body.mass = mass[b];
    body.q_offset = static_cast<std::size_t>(q_offset[b]), body.q_size = static_cast<std::size_t>(q_size[b]);
    body.v_offset = static_cast<std::size_t>(v_offset[b]), body.v_size = static_cast<std::size_t>(v_size[b]);
    body.parts = static_cast<int>(parts[b]);
    RunTables::Place place{first_position[b], first_piece, static_cast<std::size_t>(pieces[b])};
    if (place.pieces > t.piece_mesh.size() - first_piece)
      throw InputError(
          fmt::format("{}:/bodies/pieces: names more than the {} of /poses", file.path(), t.piece_mesh.size()));
    const bool deforms = place.pieces == 0 && !body.changing;
    if (deforms != (place.first_position >= 0) ||
        (deforms && place.first_position != static_cast<std::int64_t>(t.positions)))
      throw InputError(fmt::format("{}:/bodies/first_position[{}]: is {}; it must follow from the bodies before it",
                                   file.path(), b, place.first_position));
    if (deforms) {
      t.positions += body.display.vertices;
      body.display.triangles = std::vector<Triangle>(triangles.at(b).begin(), triangles.at(b).end());
    }
    std::size_t placed = 0;
    if (place.pieces == 1) {  // all bodies of a mesh share its triangles
      const auto mesh = static_cast<std::size_t>(t.piece_mesh[first_piece]);
      if (whole_mesh[mesh].empty())
        whole_mesh[mesh] = std::vector<Triangle>(mesh_triangles.at(mesh).begin(), mesh_triangles.at(mesh).end());
      body.display.triangles = whole_mesh[mesh];
      placed = t.mesh(first_piece).size();
    } else if (place.pieces > 1) {
      std::vector<Triangle> list;
      for (std::size_t i = 0; i < place.pieces; ++i) {
        const auto shift = static_cast<std::int32_t>(placed);
        for (const Triangle& c : mesh_triangles.at(static_cast<std::size_t>(t.piece_mesh[first_piece + i])))
          list.push_back({c[0] + shift, c[1] + shift, c[2] + shift});
        placed += t.mesh(first_piece + i).size();
      }
      body.display.triangles = std::move(list);
    }
    if (place.pieces > 0 && placed != body.display.vertices)
      throw InputError(
          fmt::format("{}:/bodies/vertices[{}]: is {}, but its pieces have {}", file.path(), b, vertices[b], placed));
    first_piece += place.pieces;
    body.display.lines.assign(lines.at(b).begin(), lines.at(b).end());
    // Those of pieces are known to be right: their meshes' are.
    if (place.pieces == 0) check_indices<3>(file, body.display.triangles, body.display.vertices, "/display/triangles");
    check_indices<2>(file, body.display.lines, body.display.vertices, "/display/lines");
    t.bodies.push_back(std::move(body));
    t.places.push_back(place);
  }
  if (first_piece != t.piece_mesh.size())
    throw InputError(
        fmt::format("{}:/bodies/pieces: names {} of the {} of /poses", file.path(), first_piece, t.piece_mesh.size()));
  t.parts = read_parts(file, n);
  return t;
}

}  // namespace brim
