#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "brim/core/error.h"
#include "brim/io/polygon_soup.h"
#include "brim/io/surface_reader.h"
#include "brim/mesh/mass_properties.h"
#include "io/temporary_folder.h"

namespace brim::polygon_formats_test {
namespace {

const std::string kPlyHead =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
    "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

TEST(PolygonFormats, APolygonWithADentIsSplitInsideItself) {
  PolygonSoup soup;
  soup.vertices = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 0.5, 0}, {0, 2, 0}};
  const std::vector<std::int32_t> corners = {0, 1, 2, 3, 4};
  soup.add(corners);
  ASSERT_EQ(soup.triangles().size(), 3u);
  double area = 0.0;
  for (const Triangle& t : soup.triangles()) {
    const double signed_area =
        0.5 * (soup.vertices[t[1]] - soup.vertices[t[0]]).cross(soup.vertices[t[2]] - soup.vertices[t[0]]).z();
    EXPECT_GT(signed_area, 0.0);
    area += signed_area;
  }
  EXPECT_NEAR(area, 4.0 - 1.5, 1e-14) << "a square less its dent";
}

TEST(PolygonFormats, PlyInTextAndInBothByteOrdersIsTheSame) {
  const test::TemporaryFolder folder;
  const float x[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.5f};
  std::string text = kPlyHead;
  for (int v = 0; v < 4; ++v) text += fmt::format("{} {} {}\n", x[3 * v], x[3 * v + 1], x[3 * v + 2]);
  text += "4 0 1 2 3\n";
  const PolygonSoup wanted = read_ply(folder.write("a.ply", text));
  ASSERT_EQ(wanted.vertices.size(), 4u);
  EXPECT_EQ(wanted.triangles().size(), 2u);
  EXPECT_EQ(wanted.vertices[3], Vec3(0, 1, 0.5));
  for (const bool big : {false, true}) {
    std::string bytes = kPlyHead;
    bytes.replace(bytes.find("ascii"), 5, big ? "binary_big_endian" : "binary_little_endian");
    const auto put = [&](auto value) {
      char raw[sizeof value];
      std::memcpy(raw, &value, sizeof value);
      if (big) std::reverse(raw, raw + sizeof value);
      bytes.append(raw, sizeof value);
    };
    for (const float c : x) put(c);
    put(std::uint8_t{4});
    for (std::int32_t i = 0; i < 4; ++i) put(i);
    const PolygonSoup found = read_ply(folder.write("b.ply", bytes));
    EXPECT_EQ(found.vertices, wanted.vertices);
    EXPECT_EQ(found.triangles(), wanted.triangles());
  }
}

TEST(PolygonFormats, WhatElseAPlyHoldsIsPassedOver) {
  const test::TemporaryFolder folder;
  const PolygonSoup soup = read_ply(folder.write(
      "c.ply",
      "ply\nformat ascii 1.0\nelement note 2\nproperty list uchar float words\nelement vertex 3\nproperty uchar red\n"
      "property double z\nproperty double y\nproperty double x\nelement face 1\nproperty uchar flags\nproperty list "
      "uchar uint vertex_index\nend_header\n2 1 2\n0\n9 0 0 0\n9 0 0 1\n9 0 1 0\n7 3 0 1 2\n"));
  EXPECT_EQ(soup.vertices[1], Vec3(1, 0, 0));
  EXPECT_EQ(soup.triangles().size(), 1u);
}

TEST(PolygonFormats, ObjFacesNameVerticesInAllTheirWays) {
  const test::TemporaryFolder folder;
  const PolygonSoup a = read_obj(folder.write("a.obj",
                                              "# made by hand\no square\nv 0 0 0\nv +1. 0 0\nv 1 1 .5 \\\n 1 0 0\n"
                                              "vt 0 0\nvn 0 0 1\nv 0 2 0 2\ng one\ns off\nusemtl red\n"
                                              "f 1/1/1 2//1 3/1 4 # all four\nf -4 -3 -2\nl 1 2\n"));
  const std::vector<Vec3> wanted = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}};
  EXPECT_EQ(a.vertices, wanted);
  const std::vector<Triangle> faces = {{0, 1, 2}, {0, 2, 3}, {0, 1, 2}};
  EXPECT_EQ(a.triangles(), faces);
}

TEST(PolygonFormats, OffMayHaveCommentsColoursAndItsCountsOnTheFirstLine) {
  const test::TemporaryFolder folder;
  const PolygonSoup a = read_off(folder.write(
      "a.off",
      "# made by hand\nCOFF\n\n4 1 0  # counts\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n1 1 0 1 0 0 1\n0 1 0 1 0 0 1\n"
      "4 0 1 2 3 255 0 0\n"));
  const PolygonSoup b = read_off(folder.write("b.off", "OFF 4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"));
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.triangles(), b.triangles());
  EXPECT_EQ(a.triangles().size(), 2u);
}

TEST(PolygonFormats, DamagedFilesAreRefusedAtOnce) {
  const test::TemporaryFolder folder;
  const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  const std::string bad[][2] = {
      {"a.off", "OFF\n8 12 0"},
      {"b.off", "OFF\n4 1 0\n" + square + "4 0 1 2 4\n"},
      {"c.off", "OFF\n4 1 0\n" + square + "4 0 1 2 -1\n"},
      {"d.off", "OFF\n4000000000 1 0\n" + square},
      {"e.off", "OFF\n4 1 0\n" + square + "4000000000 0 1\n"},
      {"f.off", "OFF BINARY\n4 1 0\n"},
      {"g.off", "4OFF\n1 1 0\n0 0 0 0\n"},
      {"h.ply", "ply\nformat ascii 1.0\n"},
      {"a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 4\n"},
      {"b.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 0\n"},
      {"c.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 -4\n"},
      {"d.obj", "v 0 0 0\nv 1 0 0\nv 1 1\nf 1 2 3\n"},
      {"e.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0 0\nf 1 2 3\n"},
      {"f.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 99999999999\n"},
      {"g.obj", "v 0 0 0\nv 1 0 0\nv 1 1 x\nf 1 2 3\n"},
      {"i.ply", kPlyHead + square + "4 0 1 2 -1\n"},
      {"j.ply", kPlyHead + square + "4 0 1 2 4\n"},
      {"k.ply", kPlyHead + square + "4 0 1 2 1.5\n"},
      {"l.ply", kPlyHead + square + "250 0 1 2\n"},
      {"m.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999999\nproperty float x\nend_header\n0\n"},
      {"n.ply", "ply\nformat ascii 1.0\nproperty float x\nend_header\n"},
      {"o.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n"},
      {"p.ply",
       "ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\nproperty float y\nproperty "
       "float z\nend_header\n0123"},
  };
  for (const auto& [name, text] : bad) EXPECT_THROW(read_surface(folder.write(name, text)), InputError) << name;
}

/// Bytes of good files changed at random: whatever comes of it, it is a mesh or an InputError, and soon.
TEST(PolygonFormats, MutatedFilesNeitherCrashNorHang) {
  const test::TemporaryFolder folder;
  const unsigned seed = 3;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  const std::string good[][2] = {{"a.ply", kPlyHead + "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"},
                                 {"a.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"},
                                 {"a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"}};
  int refused = 0;
  for (const auto& [name, text] : good)
    for (int n = 0; n < 1500; ++n) {
      std::string bytes = text;
      for (unsigned k = random() % 4 + 1; k > 0; --k) {
        const std::size_t at = random() % bytes.size();
        switch (random() % 3) {
          case 0:
            bytes[at] = static_cast<char>(random());
            break;
          case 1:
            bytes.erase(at, random() % 8);
            break;
          default:
            bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 8));
        }
      }
      try {
        read_surface(folder.write(name, bytes));
      } catch (const InputError&) {
        ++refused;
      }
    }
  EXPECT_GT(refused, 300) << "or the test is blind";
}

}  // namespace
}  // namespace brim::polygon_formats_test
