#include "brim/record/run_tables.h"

#include <algorithm>
#include <cstring>
#include <map>

#include "brim/body/changing_surface.h"
#include "brim/body/posed_display.h"
#include "brim/record/run_layout.h"

namespace brim {

using h5::Type;

namespace {

constexpr std::int64_t kMost = std::int64_t{1} << 40;  ///< of anything that is counted

/// Lists one after another, and where each starts.
template <class T>
struct Packed {
  std::vector<T> items;
  std::vector<std::int64_t> first = {0};
  void add(std::span<const T> list) {
    items.insert(items.end(), list.begin(), list.end());
    first.push_back(static_cast<std::int64_t>(items.size()));
  }
  std::span<const T> at(std::size_t i) const {
    const auto from = static_cast<std::size_t>(first[i]);
    return std::span(items).subspan(from, static_cast<std::size_t>(first[i + 1]) - from);
  }
};

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

namespace {

/// Reads a whole data set of rows of `width` numbers (0: plain numbers).
template <class T>
std::vector<T> read_column(const h5::File& file, const std::string& path, Type type, std::uint64_t width = 0) {
  const h5::Dataset set = file.open(path);
  const std::uint64_t rows = set.shape()[0];
  const std::vector<std::uint64_t> row = width > 0 ? std::vector<std::uint64_t>{width} : std::vector<std::uint64_t>{};
  set.need_rows(0, rows, row);
  const std::uint64_t elements = rows * std::max<std::uint64_t>(width, 1);
  std::vector<T> values(elements * (type == Type::Int32 ? 4 : 8) / sizeof(T));
  if (elements > 0) set.read(values.data(), elements, 0, rows, type);
  return values;
}

/// A column with one number per body or part, each from least to most.
std::vector<std::int64_t> read_whole(const h5::File& file, const std::string& path, std::size_t rows,
                                     std::int64_t least, std::int64_t most) {
  std::vector<std::int64_t> values = read_column<std::int64_t>(file, path, Type::Int64);
  if (values.size() != rows)
    throw InputError(fmt::format("{}:{}: has {} rows; it must have {}", file.path(), path, values.size(), rows));
  for (std::size_t i = 0; i < rows; ++i)
    if (values[i] < least || values[i] > most)
      throw InputError(
          fmt::format("{}:{}[{}]: is {}; it must be from {} to {}", file.path(), path, i, values[i], least, most));
  return values;
}

std::vector<double> read_real(const h5::File& file, const std::string& path, std::size_t rows) {
  std::vector<double> values = read_column<double>(file, path, Type::Float64);
  if (values.size() != rows)
    throw InputError(fmt::format("{}:{}: has {} rows; it must have {}", file.path(), path, values.size(), rows));
  return values;
}

std::vector<std::string> read_names(const h5::File& file, const std::string& path, std::size_t rows) {
  std::vector<std::string> values = file.read_texts(path);
  if (values.size() != rows)
    throw InputError(fmt::format("{}:{}: has {} rows; it must have {}", file.path(), path, values.size(), rows));
  return values;
}

/// Lists packed one after another: their starts must rise from 0 to the number of all items.
template <class T>
Packed<T> read_packed(const h5::File& file, const std::string& items, Type type, std::uint64_t width,
                      const std::string& starts) {
  Packed<T> p{read_column<T>(file, items, type, width), read_column<std::int64_t>(file, starts, Type::Int64)};
  if (p.first.empty() || p.first.front() != 0 || !std::is_sorted(p.first.begin(), p.first.end()) ||
      p.first.back() != static_cast<std::int64_t>(p.items.size()))
    throw InputError(
        fmt::format("{}:{}: must rise from 0 to the {} rows of {}", file.path(), starts, p.items.size(), items));
  return p;
}

template <std::size_t N>
void check_indices(const h5::File& file, std::span<const std::array<std::int32_t, N>> cells, std::size_t vertices,
                   const std::string& what) {
  for (const auto& cell : cells)
    for (const std::int32_t i : cell)
      if (i < 0 || static_cast<std::size_t>(i) >= vertices)
        throw InputError(fmt::format("{}:{}: names vertex {}; it must be from 0 to {}", file.path(), what, i,
                                     static_cast<std::int64_t>(vertices) - 1));
}

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

RunTables read_tables_v1(const h5::File& file) {
  RunTables t;
  for (int b = 0;; ++b) {
    const std::string at = "/bodies/" + std::to_string(b);
    if (!file.exists(at)) break;
    const auto whole = [&](const char* name, std::int64_t most) {
      return static_cast<std::size_t>(file.whole(at, name, 0, most));
    };
    RecordedBody body;
    body.name = file.text(at, "name");
    body.kind = file.text(at, "kind");
    body.display.kind = run_layout::display_kind(file.text(at, "display_kind"), file.path());
    body.display.two_sided = whole("two_sided", 1) != 0;
    body.display.radius = file.number(at, "radius");
    body.display.vertices = whole("vertices", kMost);
    body.immobile = whole("immobile", 1) != 0;
    body.changing = file.has_attribute(at, "changing") && whole("changing", 1) != 0;
    body.mass = file.number(at, "mass");
    body.q_offset = whole("q_offset", kMost);
    body.q_size = whole("q_size", kMost);
    body.v_offset = whole("v_offset", kMost);
    body.v_size = whole("v_size", kMost);
    body.parts = static_cast<int>(whole("parts", run_layout::kMostParts));
    if (body.display.kind == Display::Kind::Triangles && !body.changing)
      body.display.triangles = read_column<Triangle>(file, at + "/triangles", Type::Int32, 3);
    else if (body.display.kind == Display::Kind::Lines)
      body.display.lines = read_column<std::array<std::int32_t, 2>>(file, at + "/lines", Type::Int32, 2);
    check_indices<3>(file, body.display.triangles, body.display.vertices, at + "/triangles");
    check_indices<2>(file, body.display.lines, body.display.vertices, at + "/lines");
    t.bodies.push_back(std::move(body));
  }
  for (int p = 0;; ++p) {
    const std::string at = "/parts/" + std::to_string(p);
    if (!file.exists(at)) break;
    t.parts.push_back({file.text(at, "name"), file.text(at, "material"),
                       static_cast<int>(file.whole(at, "body", 0, static_cast<std::int64_t>(t.bodies.size()) - 1)),
                       static_cast<int>(file.whole(at, "part", 0, run_layout::kMostParts)),
                       file.number(at, "voxel_size")});
  }
  return t;
}

}  // namespace brim
