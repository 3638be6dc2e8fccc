// glTF as the text and numbers of its one file. Other programs read it in export_readers_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "brim/record/export/export.h"
#include "support/moving_run.h"
#include "support/text_of.h"

namespace brim::export_gltf_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The file's description, and its numbers.
class Glb {
 public:
  explicit Glb(const fs::path& file) : text_(testing::text_of(file)) {
    std::uint32_t length = 0;
    std::memcpy(&length, text_.data() + 12, sizeof length);
    root = json::parse(text_.substr(20, length));
    first_ = 20 + length + 8;
  }
  std::vector<float> numbers(const json& accessor_index) const {
    const json& accessor = root["accessors"][accessor_index.get<std::size_t>()];
    const json& view = root["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    std::vector<float> list(view["byteLength"].get<std::size_t>() / 4);
    std::memcpy(list.data(), text_.data() + first_ + view["byteOffset"].get<std::size_t>(), 4 * list.size());
    return list;
  }
  /// Values of a node's animation, empty without one.
  std::vector<float> animated(std::size_t node, const std::string& path) const {
    for (const json& channel : root["animations"][0]["channels"])
      if (channel["target"]["node"] == node && channel["target"]["path"] == path)
        return numbers(root["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()]["output"]);
    return {};
  }
  json root;

 private:
  std::string text_;
  std::size_t first_ = 0;
};

TEST(ExportGltf, LinksAreNodesBelowThatOfTheirBodyAndMoveAsAWhole) {
  const testing::MovingRun moving;
  const RunReader run(moving.folder());
  export_run(run, {.format = "gltf", .folder = (moving.path / "out").string()});
  const Glb glb(moving.path / "out/run.glb");
  const auto number =
      static_cast<int>(std::ranges::find(run.bodies(), "arm", &RecordedBody::name) - run.bodies().begin());
  const json& nodes = glb.root["nodes"];
  const auto arm = static_cast<std::size_t>(
      std::ranges::find_if(nodes, [](const json& n) { return n["name"] == "arm"; }) - nodes.begin());
  EXPECT_TRUE(std::ranges::count(nodes[0]["children"], json(arm)) == 1) << "below the root";
  ASSERT_EQ(nodes[arm]["children"].size(), 2u);
  EXPECT_FALSE(nodes[arm].contains("mesh"));
  std::size_t first = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto link = nodes[arm]["children"][k].get<std::size_t>();
    EXPECT_EQ(nodes[link]["name"], fmt::format("arm/{}", k));
    EXPECT_TRUE(std::ranges::count(nodes[0]["children"], json(link)) == 0);
    EXPECT_TRUE(glb.animated(link, "weights").empty()) << "no morph targets";
    const json& shape = glb.root["meshes"][nodes[link]["mesh"].get<std::size_t>()]["primitives"][0];
    const auto local = glb.numbers(shape["attributes"]["POSITION"]);
    const auto where = glb.animated(link, "translation"), turn = glb.animated(link, "rotation");
    ASSERT_EQ(where.size(), 3 * static_cast<std::size_t>(run.frames()));
    ASSERT_EQ(turn.size(), 4 * static_cast<std::size_t>(run.frames()));
    const std::size_t vertices = run.pieces(number)[k].vertices;
    for (std::size_t f = 0; f < static_cast<std::size_t>(run.frames()); ++f) {
      const Eigen::Quaternionf rotation(turn[4 * f + 3], turn[4 * f], turn[4 * f + 1], turn[4 * f + 2]);
      const Vec3f place(where[3 * f], where[3 * f + 1], where[3 * f + 2]);
      const auto all = run.positions(number, static_cast<std::int64_t>(f));
      // Vertices are doubled along creases: each must be one of the link's, and each of the link's be there.
      std::vector<char> met(vertices, 0);
      for (std::size_t i = 0; i + 2 < local.size(); i += 3) {
        const Vec3f x = rotation * Vec3f(local[i], local[i + 1], local[i + 2]) + place;
        std::size_t nearest = 0;
        for (std::size_t v = 0; v < vertices; ++v)
          if ((all[first + v] - x).norm() < (all[first + nearest] - x).norm()) nearest = v;
        EXPECT_LT((all[first + nearest] - x).norm(), 3e-6f) << "frame " << f;
        met[nearest] = 1;
      }
      EXPECT_EQ(std::ranges::count(met, 0), 0) << "frame " << f;
    }
    first += vertices;
  }
}

}  // namespace
}  // namespace brim::export_gltf_test
