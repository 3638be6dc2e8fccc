#include "brim/io/surface_reader.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <functional>

#include "brim/core/error.h"
#include "brim/io/obj_writer.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/topology.h"
#include "io/temporary_folder.h"
#include "mesh/data.h"

namespace brim::surface_reader_test {
namespace {

constexpr const char* kQuadObj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

std::string error_of(const std::filesystem::path& path) {
  try {
    read_surface(path);
  } catch (const InputError& e) {
    return e.what();
  }
  return "nothing thrown";
}

TEST(SurfaceReader, TriangulatesPolygonsOfAnObj) {
  const test::TemporaryFolder folder;
  const TriMesh m = read_surface(folder.write("quad.obj", kQuadObj));
  EXPECT_EQ(m.vertices.size(), 4u);
  EXPECT_EQ(m.triangles.size(), 2u);
  EXPECT_NEAR(surface_area(m), 1.0, 1e-7);
}

TEST(SurfaceReader, JoinsVerticesThatDifferInTextureOrNormalOnly) {
  const test::TemporaryFolder folder;
  const TriMesh m = read_surface(folder.write("seam.obj",
                                              "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 0\nvt 0 0\nvt 1 1\nvn 0 0 "
                                              "1\nvn 0 1 0\nf 1/1/1 2/1/1 3/1/1\nf 5/2/2 3/2/2 4/2/2\n"));
  EXPECT_EQ(m.vertices.size(), 4u);
  EXPECT_EQ(boundary_edges(m.triangles).size(), 4u);
}

TEST(SurfaceReader, ReadsTheSameSolidFromEveryFormat) {
  const test::TemporaryFolder folder;
  const TriMesh box = shapes::box({1.0, 0.5, 0.25}, 2);
  std::string off = fmt::format("OFF\n{} {} 0\n", box.vertices.size(), box.triangles.size());
  std::string ply = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face "
      "{}\nproperty list uchar int vertex_indices\nend_header\n",
      box.vertices.size(), box.triangles.size());
  std::string stl = "solid box\n";
  for (const Vec3& x : box.vertices) {
    off += fmt::format("{} {} {}\n", x.x(), x.y(), x.z());
    ply += fmt::format("{} {} {}\n", x.x(), x.y(), x.z());
  }
  for (const Triangle& t : box.triangles) {
    off += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    ply += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    stl += "facet normal 0 0 0\nouter loop\n";
    for (const std::int32_t v : t)
      stl += fmt::format("vertex {} {} {}\n", box.vertices[v].x(), box.vertices[v].y(), box.vertices[v].z());
    stl += "endloop\nendfacet\n";
  }
  stl += "endsolid box\n";
  // STL again as bytes: 80 bytes of header, count, then 50 bytes a triangle.
  std::string binary(80, ' ');
  const auto put = [&](const auto& value) { binary.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<std::uint32_t>(box.triangles.size()));
  for (const Triangle& t : box.triangles) {
    for (int k = 0; k < 3; ++k) put(0.0f);
    for (const std::int32_t v : t)
      for (int k = 0; k < 3; ++k) put(static_cast<float>(box.vertices[v][k]));
    put(std::uint16_t{0});
  }
  write_obj(folder.path / "box.obj", box);
  for (const std::filesystem::path& path :
       {folder.write("box.off", off), folder.write("box.ply", ply), folder.write("box.stl", stl),
        folder.write("BINARY.STL", binary), folder.path / "box.obj"}) {
    SCOPED_TRACE(path.string());
    const MeshReport r = inspect(read_surface(path));
    EXPECT_TRUE(r.closed() && r.oriented() && r.manifold()) << r.summary();
    EXPECT_EQ(r.vertices, box.vertices.size());
    EXPECT_NEAR(r.volume, 0.125, 1e-7);
  }
}

TEST(SurfaceReader, AppliesTheTransformsOfNodes) {
  // One triangle of area 1/2 in a buffer, placed by a node that mirrors x, doubles all lengths and moves by (1, 2, 3).
  const test::TemporaryFolder folder;
  std::string bytes;
  for (const float f : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f})
    bytes.append(reinterpret_cast<const char*>(&f), 4);
  folder.write("triangle.bin", bytes);
  const TriMesh m = read_surface(folder.write("triangle.gltf", R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"translation": [1, 2, 3], "scale": [-2, 2, 2], "children": [1]}, {"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "buffers": [{"uri": "triangle.bin", "byteLength": 36}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0,0,0], "max": [1,1,0]}]})"));
  ASSERT_EQ(m.triangles.size(), 1u);
  EXPECT_NEAR(surface_area(m), 2.0, 1e-6);
  const Aabb box = bounds(m.vertices);
  EXPECT_NEAR((box.lo - Vec3(-1, 2, 3)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((box.hi - Vec3(1, 4, 3)).norm(), 0.0, 1e-6);
  const Triangle& t = m.triangles[0];
  const Vec3 n = (m.vertices[t[1]] - m.vertices[t[0]]).cross(m.vertices[t[2]] - m.vertices[t[0]]);
  EXPECT_GT(n.z(), 0.0) << "a mirrored triangle keeps its front";
}

TEST(SurfaceReader, NamesWhatIsWrongWithAFile) {
  const test::TemporaryFolder folder;
  const auto says = [](const std::filesystem::path& path, const std::string& words) {
    const std::string said = error_of(path);
    EXPECT_NE(said.find(words), std::string::npos) << said;
    EXPECT_NE(said.find(path.filename().string()), std::string::npos) << said;
  };
  says(folder.path / "absent.obj", "no such file");
  says(folder.path, "not a file");
  says(folder.write("empty.obj", ""), "empty");
  says(folder.write("notes.txt", "hello"), ".obj .stl .ply");
  says(folder.write("broken.ply", "this is no mesh\n"), "not a readable ply mesh");
  says(folder.write("broken.glb", "this is no mesh\n"), "not a readable glb mesh");
  says(folder.write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n"), "not finite");
  says(folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"), "no area");
  EXPECT_NE(error_of(folder.write("points.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\n")), "nothing thrown");
  EXPECT_NE(error_of(folder.write("words.obj", "these are not the lines\nof a mesh at all\n")), "nothing thrown");
}

TEST(SurfaceReader, ReadsRealMeshes) {
  struct Expected {
    const char* name;
    bool closed;
  };
  int found = 0;
  for (const Expected& e :
       {Expected{"spot.obj", true}, Expected{"fandisk.obj", true}, Expected{"rocker-arm.obj", true},
        Expected{"stanford-bunny.obj", false}, Expected{"teapot.obj", false}, Expected{"suzanne.obj", false}}) {
    const auto path = test::data_file(e.name);
    if (path.empty()) continue;
    ++found;
    const TriMesh mesh = read_surface(path), plain_mesh = weld(test::read_plain_obj(path), 0.0);
    const MeshReport r = inspect(mesh), plain = inspect(plain_mesh);
    SCOPED_TRACE(std::string(e.name) + ": " + r.summary() + " / " + plain.summary());
    EXPECT_EQ(r.closed(), e.closed);
    EXPECT_EQ(r.triangles, plain.triangles);
    EXPECT_EQ(r.vertices, plain.vertices);
    // The two readers may cut a quad that is not flat along different diagonals (suzanne: 3e-4 of the area).
    EXPECT_NEAR(surface_area(mesh) / surface_area(plain_mesh), 1.0, 1e-3);
    if (e.closed) {
      EXPECT_NEAR(r.volume / plain.volume, 1.0, 1e-6);
    }
  }
  if (found == 0) GTEST_SKIP() << "no test data";
}

TEST(ObjWriter, WritesWhatThePlainReaderReadsBackBitForBit) {
  const test::TemporaryFolder folder;
  const TriMesh m = shapes::blob(77, 0.3, 3);
  write_obj(folder.path / "blob.obj", m);
  const TriMesh back = test::read_plain_obj(folder.path / "blob.obj");
  EXPECT_EQ(back.vertices, m.vertices);
  EXPECT_EQ(back.triangles, m.triangles);
  EXPECT_THROW(write_obj(folder.path / "absent" / "blob.obj", m), InputError);
}

}  // namespace
}  // namespace brim::surface_reader_test
