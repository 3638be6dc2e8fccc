#include "brim/io/tet_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <functional>

#include "brim/core/error.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/tet_lattice.h"
#include "io/temporary_folder.h"

namespace brim::tet_reader_test {
namespace {

// Bytes of a value in the given order.
template <class T>
void put(std::string& out, T value, std::endian order) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  if (order != std::endian::native) std::reverse(bytes, bytes + sizeof(T));
  out.append(bytes, sizeof(T));
}

// The mesh with tags that do not count from 1 and a triangle, which the reader must pass over.
std::string gmsh_2(const TetMesh& m) {
  std::string s = fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", m.vertices.size());
  for (std::size_t v = 0; v < m.vertices.size(); ++v)
    s += fmt::format("{} {} {} {}\n", 10 * v + 7, m.vertices[v].x(), m.vertices[v].y(), m.vertices[v].z());
  s += fmt::format("$EndNodes\n$Elements\n{}\n1 2 2 0 1 7 17 27\n", m.tets.size() + 1);
  for (std::size_t e = 0; e < m.tets.size(); ++e) {
    const Tetrahedron& t = m.tets[e];
    s += fmt::format("{} 4 2 0 1 {} {} {} {}\n", e + 2, 10 * t[0] + 7, 10 * t[1] + 7, 10 * t[2] + 7, 10 * t[3] + 7);
  }
  return s + "$EndElements\n";
}

std::string gmsh_2_binary(const TetMesh& m, std::endian order) {
  std::string s = "$MeshFormat\n2.2 1 8\n";
  put<std::int32_t>(s, 1, order);
  s += fmt::format("\n$EndMeshFormat\n$Nodes\n{}\n", m.vertices.size());
  for (std::size_t v = 0; v < m.vertices.size(); ++v) {
    put(s, static_cast<std::int32_t>(v + 1), order);
    for (int k = 0; k < 3; ++k) put(s, m.vertices[v][k], order);
  }
  s += fmt::format("\n$EndNodes\n$Elements\n{}\n", m.tets.size() + 1);
  for (const std::int32_t i : {2, 1, 2, 1, 0, 1, 1, 2, 3}) put(s, i, order);  // a block of one triangle
  for (const std::int32_t i : {4, static_cast<std::int32_t>(m.tets.size()), 2}) put(s, i, order);
  for (std::size_t e = 0; e < m.tets.size(); ++e) {
    for (const std::int32_t i : {static_cast<std::int32_t>(e + 2), 0, 1}) put(s, i, order);
    for (const std::int32_t v : m.tets[e]) put(s, v + 1, order);
  }
  return s + "\n$EndElements\n";
}

std::string gmsh_4(const TetMesh& m) {
  const std::size_t n = m.vertices.size(), half = n / 2;
  std::string s = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 0\n$EndEntities\n";
  s += fmt::format("$Nodes\n2 {} 1 {}\n", n, n);
  for (const auto& [first, last] : {std::pair{std::size_t{0}, half}, std::pair{half, n}}) {
    s += fmt::format("3 1 0 {}\n", last - first);
    for (std::size_t v = first; v < last; ++v) s += fmt::format("{}\n", v + 1);
    for (std::size_t v = first; v < last; ++v)
      s += fmt::format("{} {} {}\n", m.vertices[v].x(), m.vertices[v].y(), m.vertices[v].z());
  }
  s += fmt::format("$EndNodes\n$Elements\n2 {} 1 {}\n2 1 2 1\n1 1 2 3\n3 1 4 {}\n", m.tets.size() + 1,
                   m.tets.size() + 1, m.tets.size());
  for (std::size_t e = 0; e < m.tets.size(); ++e) {
    const Tetrahedron& t = m.tets[e];
    s += fmt::format("{} {} {} {} {}\n", e + 2, t[0] + 1, t[1] + 1, t[2] + 1, t[3] + 1);
  }
  return s + "$EndElements\n";
}

// Legacy VTK; one vertex cell beside the tetrahedra.
std::string vtk(const TetMesh& m, bool binary, bool offsets) {
  const std::size_t n = m.tets.size() + 1;
  std::string s = fmt::format("# vtk DataFile Version {}\nmesh\n{}\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n",
                              offsets ? "5.1" : "2.0", binary ? "BINARY" : "ASCII", m.vertices.size());
  const auto value = [&](auto x) {
    if (binary)
      put(s, x, std::endian::big);
    else
      s += fmt::format("{} ", x);
  };
  for (const Vec3& x : m.vertices)
    for (int k = 0; k < 3; ++k) value(x[k]);
  if (offsets) {
    s += fmt::format("\nMETADATA\nINFORMATION 0\n\nCELLS {} {}\nOFFSETS vtktypeint64\n", n + 1, 4 * (n - 1) + 1);
    value(std::int64_t{0});
    for (std::size_t e = 0; e < n; ++e) value(static_cast<std::int64_t>(1 + 4 * e));
    s += "\nCONNECTIVITY vtktypeint64\n";
    value(std::int64_t{0});
    for (const Tetrahedron& t : m.tets)
      for (const std::int32_t v : t) value(static_cast<std::int64_t>(v));
  } else {
    s += fmt::format("\nCELLS {} {}\n", n, 5 * (n - 1) + 2);
    value(1), value(0);
    for (const Tetrahedron& t : m.tets) {
      value(4);
      for (const std::int32_t v : t) value(v);
    }
  }
  s += fmt::format("\nCELL_TYPES {}\n", n);
  value(1);
  for (std::size_t e = 1; e < n; ++e) value(10);
  return s + "\n";
}

TEST(TetReader, ReadsTheSameMeshFromEveryFormat) {
  const test::TemporaryFolder folder;
  const TetMesh m = tet_lattice(shapes::icosphere(0.5, 3), 0.25);
  for (const auto& path :
       {folder.write("a.msh", gmsh_2(m)), folder.write("b.msh", gmsh_2_binary(m, std::endian::little)),
        folder.write("c.msh", gmsh_2_binary(m, std::endian::big)), folder.write("d.msh", gmsh_4(m)),
        folder.write("e.vtk", vtk(m, false, false)), folder.write("f.vtk", vtk(m, true, false)),
        folder.write("g.vtk", vtk(m, false, true)), folder.write("H.VTK", vtk(m, true, true))}) {
    SCOPED_TRACE(path.string());
    const TetMesh read = read_tets(path);
    EXPECT_EQ(read.tets, m.tets);
    EXPECT_EQ(read.vertices, m.vertices);
  }
}

TetMesh two_tets() { return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, {{0, 1, 2, 3}, {1, 2, 3, 4}}}; }

TEST(TetReader, TurnsAMeshThatIsInsideOutAsAWhole) {
  const test::TemporaryFolder folder;
  TetMesh m = two_tets();
  ASSERT_NEAR(tet_quality(m).min_volume, 1.0 / 6.0, 1e-15);
  for (Tetrahedron& t : m.tets) std::swap(t[0], t[1]);
  EXPECT_NEAR(tet_quality(read_tets(folder.write("turned.msh", gmsh_2(m)))).min_volume, 1.0 / 6.0, 1e-15);
}

TEST(TetReader, DropsVerticesThatNoTetrahedronUses) {
  const test::TemporaryFolder folder;
  TetMesh m = two_tets();
  m.vertices.insert(m.vertices.begin(), Vec3(9, 9, 9));
  for (Tetrahedron& t : m.tets)
    for (std::int32_t& v : t) ++v;
  const TetMesh read = read_tets(folder.write("spare.vtk", vtk(m, false, false)));
  EXPECT_EQ(read.vertices, two_tets().vertices);
  EXPECT_EQ(read.tets, two_tets().tets);
}

TEST(TetReader, NamesWhatIsWrongWithAFile) {
  const test::TemporaryFolder folder;
  const auto says = [](const std::filesystem::path& path, const std::string& words) {
    std::string said = "nothing thrown";
    try {
      read_tets(path);
    } catch (const InputError& e) {
      said = e.what();
    }
    EXPECT_NE(said.find(words), std::string::npos) << said;
    EXPECT_NE(said.find(path.filename().string()), std::string::npos) << said;
  };
  says(folder.path / "absent.msh", "no such file");
  says(folder.write("empty.msh", ""), "empty");
  says(folder.write("mesh.obj", "v 0 0 0"), ".msh and .vtk");
  says(folder.write("words.msh", "hello\n"), "not a Gmsh mesh");
  says(folder.write("words.vtk", "hello\n"), "not a legacy VTK file");
  says(folder.write("old.msh", "$MeshFormat\n4.0 0 8\n$EndMeshFormat\n"), "version 2.2 or 4.1");
  says(folder.write("binary4.msh", "$MeshFormat\n4.1 1 8\n$EndMeshFormat\n"), "binary Gmsh 4.1");
  says(folder.write("points.vtk", "# vtk DataFile Version 2.0\nx\nASCII\nDATASET POLYDATA\n"), "UNSTRUCTURED_GRID");

  TetMesh m = two_tets();
  std::swap(m.tets[1][0], m.tets[1][1]);
  says(folder.write("inverted.msh", gmsh_2(m)), "1 of 2 tetrahedra are inverted, the first is number 1");
  m = two_tets();
  m.vertices[4] = {1.0 / 3, 1.0 / 3, 1.0 / 3};
  says(folder.write("flat.vtk", vtk(m, true, false)), "1 of 2 tetrahedra are flat, the first is number 1");
  m = two_tets();
  m.tets[1][2] = 12;
  says(folder.write("range.vtk", vtk(m, false, false)), "names vertex 12, but there are 5");
  says(folder.write("range.msh", gmsh_2(m)), "names node 127");
  m = two_tets();
  m.vertices[2].y() = std::nan("");
  says(folder.write("nan.msh", gmsh_2(m)), "not finite");
  m = two_tets();
  m.tets.clear();
  says(folder.write("none.msh", gmsh_2(m)), "no tetrahedra");
  says(folder.write("none.vtk", vtk(m, true, true)), "no tetrahedra");
  says(folder.write(
           "huge.vtk",
           "# vtk DataFile Version 2.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9000000000000 float\n0 0 0\n"),
       "truncated");
}

TEST(TetReader, RefusesEveryTruncation) {
  // A file cut anywhere before its last number is refused or, in ASCII, cut inside the last number's digits.
  const test::TemporaryFolder folder;
  const TetMesh m = two_tets();
  for (const auto& [name, text] : {std::pair<const char*, std::string>{"a.msh", gmsh_2(m)},
                                   {"b.msh", gmsh_2_binary(m, std::endian::little)},
                                   {"c.msh", gmsh_4(m)},
                                   {"d.vtk", vtk(m, true, false)},
                                   {"e.vtk", vtk(m, true, true)},
                                   {"f.vtk", vtk(m, false, false)}})
    for (std::size_t length = 0; length + 4 < text.size(); ++length) {
      SCOPED_TRACE(fmt::format("{} cut to {} of {} bytes", name, length, text.size()));
      EXPECT_THROW(read_tets(folder.write(name, text.substr(0, length))), InputError);
    }
}

}  // namespace
}  // namespace brim::tet_reader_test
