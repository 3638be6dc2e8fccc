#include "brim/scene/given_arrays.h"

#include <gtest/gtest.h>

#include "brim/body/body.h"
#include "brim/io/surface_reader.h"
#include "brim/io/tet_reader.h"
#include "brim/mesh/primitives.h"
#include "brim/scene/scene.h"

namespace brim::given_arrays_test {
namespace {

constexpr const char* kScene = R"({"brim": 1, "name": "given", "frames": 1, "bodies": [
  {"kind": "cloth", "name": "sheet", "mesh": "here/sheet", "thickness": 0.1},
  {"kind": "finite_elements", "name": "soft", "tet_mesh": "here/soft"},
  {"kind": "rigid", "name": "solid", "shape": {"kind": "mesh", "file": "here/solid"}},
  {"kind": "image_volume", "name": "image", "file": "here/image", "window": [0.5, 0.5]}]})";

class Ones final : public SliceSource {
 public:
  void read(int, std::span<double> out) override { std::fill(out.begin(), out.end(), 1.0); }
};

std::shared_ptr<GivenArrays> all_arrays() {
  auto arrays = std::make_shared<GivenArrays>();
  arrays->surfaces["here/sheet"] = clean_surface(shapes::grid(2, 2, 1.0, 1.0), "sheet");
  arrays->surfaces["here/solid"] = clean_surface(shapes::box(Vec3(1, 2, 3)), "solid");
  arrays->tets["here/soft"] = clean_tets({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}}, "soft");
  VolumeInfo info;
  info.size = Vec3i(4, 5, 6);
  info.unit = 1.0;
  info.axes = 0.1 * Mat3::Identity();
  info.encoding = VolumeInfo::Encoding::Slices;
  info.slices = std::make_shared<Ones>();
  arrays->volumes["here/image"] = info;
  return arrays;
}

TEST(GivenArrays, StandWhereASceneNamesFiles) {
  Document document = parse_document(kScene, "given.json");
  document.arrays = all_arrays();
  const auto bodies = build_bodies(check_scene(std::move(document)));
  ASSERT_EQ(bodies.size(), 4u);
  EXPECT_EQ(bodies[0]->q_size(), 27u);
  EXPECT_EQ(bodies[1]->q_size(), 12u);
  EXPECT_NEAR(bodies[2]->mass(), 6000.0, 1e-9);
  EXPECT_NEAR(bodies[3]->mass(), 1000.0 * 0.4 * 0.5 * 0.6, 1.0);
}

TEST(GivenArrays, OtherNamesAreFiles) {
  Document document = parse_document(kScene, "given.json");
  auto arrays = all_arrays();
  arrays->tets.clear();
  document.arrays = arrays;
  const Scene scene = check_scene(std::move(document));
  try {
    build_bodies(scene);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("given.json:3: /bodies/1/tet_mesh: \"here/soft\": no such file"),
              std::string::npos)
        << e.what();
  }
}

TEST(GivenArrays, SurfacesAreRoundedToSinglePrecision) {
  TriMesh mesh = shapes::grid(3, 3, 3.14159265358979, 3.14159265358979);
  for (const Vec3& x : clean_surface(mesh, "sheet").vertices)
    for (const double number : x) EXPECT_EQ(number, static_cast<double>(static_cast<float>(number)));
}

TEST(GivenArrays, BrokenMeshesAreRefusedByName) {
  EXPECT_THROW(clean_surface({{{0, 0, 0}}, {}}, "none"), InputError);
  EXPECT_THROW(clean_surface({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 3}}}, "outside"), InputError);
  EXPECT_THROW(clean_tets({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2, 3}}}, "flat"), InputError);
  // All of them inside out: turned.
  const TetMesh turned = clean_tets({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 3, 2}}}, "turned");
  EXPECT_EQ(turned.tets[0], (Tetrahedron{0, 1, 2, 3}));
}

}  // namespace
}  // namespace brim::given_arrays_test
