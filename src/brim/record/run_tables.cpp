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

/// Columns of /bodies.
struct BodyColumns {
  std::vector<std::string> name, kind, display_kind;
  std::vector<double> mass, radius;
  std::vector<std::int64_t> two_sided, vertices, changing, immobile, q_offset, q_size, v_offset, v_size, parts, pieces,
      first_position;
};

BodyColumns read_body_columns(const h5::File& file) {
  BodyColumns c;
  c.name = file.read_texts("/bodies/name");
  const std::size_t n = c.name.size();
  c.kind = read_names(file, "/bodies/kind", n);
  c.display_kind = read_names(file, "/bodies/display_kind", n);
  c.mass = read_real(file, "/bodies/mass", n);
  c.radius = read_real(file, "/bodies/radius", n);
  const auto whole = [&](const char* column, std::int64_t least, std::int64_t most) {
    return read_whole(file, std::string("/bodies/") + column, n, least, most);
  };
  c.two_sided = whole("two_sided", 0, 1);
  c.vertices = whole("vertices", 0, kMost);
  c.changing = whole("changing", 0, 1);
  c.immobile = whole("immobile", 0, 1);
  c.q_offset = whole("q_offset", 0, kMost);
  c.q_size = whole("q_size", 0, kMost);
  c.v_offset = whole("v_offset", 0, kMost);
  c.v_size = whole("v_size", 0, kMost);
  c.parts = whole("parts", 0, run_layout::kMostParts);
  c.pieces = whole("pieces", 0, run_layout::kMostParts);
  c.first_position = whole("first_position", -1, kMost);
  return c;
}

/// Reads the meshes of solids into the tables, and which of them each piece has. @return their triangles
Packed<Triangle> read_meshes(const h5::File& file, RunTables& t) {
  auto meshes = read_packed<Vec3>(file, "/meshes/vertices", Type::Float64, 3, "/meshes/first_vertex");
  auto triangles = read_packed<Triangle>(file, "/meshes/triangles", Type::Int32, 3, "/meshes/first_triangle");
  if (triangles.first.size() != meshes.first.size())
    throw InputError(file.path() + ":/meshes: the lists of vertices and of triangles must be of equally many meshes");
  const auto count = static_cast<std::int32_t>(meshes.first.size()) - 1;
  for (std::int32_t m = 0; m < count; ++m)
    check_indices(file, triangles.at(static_cast<std::size_t>(m)), meshes.at(static_cast<std::size_t>(m)).size(),
                  "/meshes/triangles");
  t.piece_mesh = read_column<std::int32_t>(file, "/poses/mesh", Type::Int32);
  for (const std::int32_t m : t.piece_mesh)
    if (m < 0 || m >= count)
      throw InputError(
          fmt::format("{}:/poses/mesh: names mesh {}; it must be from 0 to {}", file.path(), m, count - 1));
  t.rest = std::move(meshes.items);
  t.mesh_first_vertex = std::move(meshes.first);
  return triangles;
}

/// Reads the bodies, each with its part of the lists that they share.
class BodyReader {
 public:
  BodyReader(const h5::File& file, RunTables& tables)
      : file_(file),
        tables_(tables),
        columns_(read_body_columns(file)),
        triangles_(read_packed<Triangle>(file, "/display/triangles", Type::Int32, 3, "/display/first_triangle")),
        lines_(read_packed<std::array<std::int32_t, 2>>(file, "/display/lines", Type::Int32, 2, "/display/first_line")),
        mesh_triangles_(read_meshes(file, tables)),
        whole_mesh_(mesh_triangles_.first.size() - 1) {
    for (const auto& [list, what] :
         {std::pair(&triangles_.first, "/display/first_triangle"), std::pair(&lines_.first, "/display/first_line")})
      if (list->size() != size() + 1)
        throw InputError(fmt::format("{}:{}: must have {} rows", file.path(), what, size() + 1));
  }

  std::size_t size() const { return columns_.name.size(); }

  void read() {
    for (std::size_t b = 0; b < size(); ++b) read(b);
    if (first_piece_ != tables_.piece_mesh.size())
      throw InputError(fmt::format("{}:/bodies/pieces: names {} of the {} of /poses", file_.path(), first_piece_,
                                   tables_.piece_mesh.size()));
  }

 private:
  void read(std::size_t b) {
    RecordedBody body = described(b);
    const RunTables::Place place = placed(b, body);
    Display& display = body.display;
    if (place.first_position >= 0) {
      tables_.positions += display.vertices;
      display.triangles = std::vector<Triangle>(triangles_.at(b).begin(), triangles_.at(b).end());
    }
    if (place.pieces > 0) {
      const std::size_t vertices = place.pieces == 1 ? show_mesh(display) : show_pieces(place.pieces, display);
      if (vertices != display.vertices)
        throw InputError(fmt::format("{}:/bodies/vertices[{}]: is {}, but its pieces have {}", file_.path(), b,
                                     columns_.vertices[b], vertices));
    }
    first_piece_ += place.pieces;
    display.lines.assign(lines_.at(b).begin(), lines_.at(b).end());
    // Those of pieces are known to be right: their meshes' are.
    if (place.pieces == 0) check_indices<3>(file_, display.triangles, display.vertices, "/display/triangles");
    check_indices<2>(file_, display.lines, display.vertices, "/display/lines");
    tables_.bodies.push_back(std::move(body));
    tables_.places.push_back(place);
  }

  /// What the columns say of a body.
  RecordedBody described(std::size_t b) const {
    const BodyColumns& c = columns_;
    RecordedBody body;
    body.name = c.name[b];
    body.kind = c.kind[b];
    body.display.kind = run_layout::display_kind(c.display_kind[b], file_.path());
    body.display.two_sided = c.two_sided[b] != 0;
    body.display.radius = c.radius[b];
    body.display.vertices = static_cast<std::size_t>(c.vertices[b]);
    body.immobile = c.immobile[b] != 0;
    body.changing = c.changing[b] != 0;
    body.mass = c.mass[b];
    body.q_offset = static_cast<std::size_t>(c.q_offset[b]), body.q_size = static_cast<std::size_t>(c.q_size[b]);
    body.v_offset = static_cast<std::size_t>(c.v_offset[b]), body.v_size = static_cast<std::size_t>(c.v_size[b]);
    body.parts = static_cast<int>(c.parts[b]);
    return body;
  }

  /// Place of a body behind those before it, which must be the place that the file says.
  RunTables::Place placed(std::size_t b, const RecordedBody& body) const {
    const RunTables::Place place{columns_.first_position[b], first_piece_,
                                 static_cast<std::size_t>(columns_.pieces[b])};
    if (place.pieces > tables_.piece_mesh.size() - first_piece_)
      throw InputError(
          fmt::format("{}:/bodies/pieces: names more than the {} of /poses", file_.path(), tables_.piece_mesh.size()));
    const bool deforms = place.pieces == 0 && !body.changing;
    if (deforms != (place.first_position >= 0) ||
        (deforms && place.first_position != static_cast<std::int64_t>(tables_.positions)))
      throw InputError(fmt::format("{}:/bodies/first_position[{}]: is {}; it must follow from the bodies before it",
                                   file_.path(), b, place.first_position));
    return place;
  }

  /// Gives a body of one piece the triangles of its mesh, which all bodies of a mesh share. @return vertices
  std::size_t show_mesh(Display& display) {
    const auto mesh = static_cast<std::size_t>(tables_.piece_mesh[first_piece_]);
    if (whole_mesh_[mesh].empty())
      whole_mesh_[mesh] = std::vector<Triangle>(mesh_triangles_.at(mesh).begin(), mesh_triangles_.at(mesh).end());
    display.triangles = whole_mesh_[mesh];
    return tables_.mesh(first_piece_).size();
  }

  /// Joins the triangles of several pieces. @return vertices
  std::size_t show_pieces(std::size_t pieces, Display& display) const {
    std::size_t vertices = 0;
    std::vector<Triangle> list;
    for (std::size_t i = 0; i < pieces; ++i) {
      const auto shift = static_cast<std::int32_t>(vertices);
      for (const Triangle& c : mesh_triangles_.at(static_cast<std::size_t>(tables_.piece_mesh[first_piece_ + i])))
        list.push_back({c[0] + shift, c[1] + shift, c[2] + shift});
      vertices += tables_.mesh(first_piece_ + i).size();
    }
    display.triangles = std::move(list);
    return vertices;
  }

  const h5::File& file_;
  RunTables& tables_;
  BodyColumns columns_;
  Packed<Triangle> triangles_;
  Packed<std::array<std::int32_t, 2>> lines_;
  Packed<Triangle> mesh_triangles_;
  std::vector<SharedList<Triangle>> whole_mesh_;  ///< triangles of the meshes of bodies of one piece
  std::size_t first_piece_ = 0;                   ///< of the next body
};

}  // namespace

RunTables read_tables(const h5::File& file) {
  RunTables t;
  BodyReader bodies(file, t);
  bodies.read();
  t.parts = read_parts(file, bodies.size());
  return t;
}

}  // namespace brim
