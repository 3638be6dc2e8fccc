// export.json: a script finds every body, file and frame by it, without a guess.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "brim/record/export/export.h"
#include "support/moving_run.h"
#include "support/text_of.h"

namespace brim::export_catalogue_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class ExportCatalogue : public ::testing::Test {
 protected:
  json catalogue_of(const std::string& format, const std::string& frames = "") {
    out_ = made_.path / format;
    export_run(RunReader(made_.folder()), {.format = format, .folder = out_.string(), .frames = frames},
               [this](std::int64_t frame) -> const World& { return made_.world_at(frame); });
    return json::parse(testing::text_of(out_ / "export.json"));
  }
  static std::string at_frame(const std::string& pattern, std::int64_t frame) {
    char name[300];
    std::snprintf(name, sizeof name, pattern.c_str(), static_cast<int>(frame));
    return name;
  }
  static const json& body(const json& catalogue, const std::string& name) {
    for (const json& b : catalogue["bodies"])
      if (b["name"] == name) return b;
    return catalogue.at("no such body");
  }

  testing::MovingRun made_;
  fs::path out_;
};

TEST_F(ExportCatalogue, NamesTheFileOfEveryBodyInEveryFrame) {
  for (const char* format : {"vtk", "vtu", "xdmf", "obj", "ply", "gltf", "usda", "npz"}) {
    const json c = catalogue_of(format, "1:5:2");
    EXPECT_EQ(c["frames"], (json{1, 3, 5})) << format;
    ASSERT_EQ(c["bodies"].size(), 13u) << format;
    std::set<std::string> named = {"run.pvd", "run.h5"};  // what only another file points to
    for (const json& b : c["bodies"])
      for (const std::int64_t f : c["frames"]) {
        const std::string file = at_frame(b["file"], f);
        EXPECT_TRUE(fs::exists(out_ / file)) << format << " " << file;
        named.insert(file);
      }
    if (c["contacts"].contains("file"))
      for (const std::int64_t f : c["frames"]) named.insert(at_frame(c["contacts"]["file"], f));
    for (const std::string file : c["files"]) EXPECT_TRUE(named.contains(file)) << format << " " << file;
  }
}

TEST_F(ExportCatalogue, TellsKindsTimesRemovalsVelocitiesAndParts) {
  const json c = catalogue_of("vtk");
  EXPECT_EQ(c["format"], "vtk");
  EXPECT_NEAR(c["times"][3].get<double>(), 0.024, 1e-12);
  const json& net = body(c, "net");
  EXPECT_EQ(net["kind"], "mass_spring");
  EXPECT_EQ(net["display"], "lines");
  EXPECT_EQ(net["file"], "net_%05d.vtp");
  EXPECT_EQ(net["removed"], (json{5, 6}));
  EXPECT_EQ(net["velocity"], "recorded");
  EXPECT_EQ(body(c, "floor")["file"], "floor.vtp");
  EXPECT_EQ(body(c, "floor")["still"], true);
  EXPECT_EQ(body(c, "water")["changing"], true);
  EXPECT_EQ(body(c, "water")["velocity"], "map");
  EXPECT_EQ(body(c, "arm")["pieces"].size(), 2u);
  EXPECT_EQ(body(c, "arm")["pieces"][1]["first_vertex"], body(c, "arm")["pieces"][0]["vertices"]);
  // Contacts name parts by their number, which is the place in this list.
  ASSERT_EQ(c["parts"].size(), 14u);
  EXPECT_EQ(c["parts"][12]["body"], "arm");
  EXPECT_EQ(catalogue_of("obj")["bodies"][0]["velocity"], "none");
}

TEST_F(ExportCatalogue, PathsLeadToPrimsAndNodes) {
  const json usda = catalogue_of("usda");
  const std::string text = testing::text_of(out_ / "run.usda");
  EXPECT_EQ(body(usda, "arm")["path"], "/World/arm");
  EXPECT_EQ(body(usda, "arm")["pieces"][1]["path"], "/World/arm/piece_1");
  EXPECT_EQ(usda["contacts"]["path"], "/World/contacts");
  EXPECT_NE(text.find("def Mesh \"piece_1\""), std::string::npos);
  const json gltf = catalogue_of("gltf");
  EXPECT_EQ(body(gltf, "water")["path"], "water_%05d");
  EXPECT_FALSE(gltf["contacts"].contains("file"));
  const std::string glb = testing::text_of(out_ / "run.glb");
  for (const char* node : {"\"name\":\"water_00003\"", "\"name\":\"arm/1\""})
    EXPECT_NE(glb.find(node), std::string::npos) << node;
}

}  // namespace
}  // namespace brim::export_catalogue_test
