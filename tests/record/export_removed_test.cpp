// What each format has for a body that the timeline has removed: nothing at all, not a body of no size.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "brim/record/export/export.h"
#include "support/made_run.h"
#include "support/removing_run.h"
#include "support/text_of.h"

namespace brim::export_removed_test {
namespace {

namespace fs = std::filesystem;
using testing::RemovingRun;
using testing::text_of;

/// A body that is always there comes first; all others are gone from frame kGone on.
class RemovedBodies : public ::testing::Test {
 protected:
  fs::path exported(const std::string& format, const std::string& frames = "") {
    const RunReader run(made_.folder());
    const fs::path out = made_.path / ("out_" + format + frames);
    export_run(run, {.format = format, .folder = out.string(), .frames = frames}, world_at());
    return out;
  }
  WorldAt world_at() {
    return [this](std::int64_t frame) -> const World& {
      world_.emplace(build_world(made_.scene));
      world_->set_state(RunReader(made_.folder()).state(frame));
      return *world_;
    };
  }
  RemovingRun made_;
  std::optional<World> world_;
};

TEST_F(RemovedBodies, AreNamedByTheReaderFromTheFrameOfTheirRemovalOn) {
  const RunReader run(made_.folder());
  for (std::int64_t f = 0; f < run.frames(); ++f) {
    const std::vector<int> removed = run.removed(f);
    EXPECT_EQ(removed.size(), f < RemovingRun::kGone ? 0u : run.bodies().size() - 1) << f;
    EXPECT_EQ(std::count(removed.begin(), removed.end(), 0), 0) << "the floor stays";
  }
  EXPECT_EQ(run.bodies()[1].name, "stone");
  EXPECT_TRUE(run.still(0));
  EXPECT_FALSE(run.still(1)) << "the one point of it has not moved, but is gone";
}

TEST_F(RemovedBodies, HaveNoPointsAndCellsInVtkAndVtu) {
  for (const char* format : {"vtk", "vtu"}) {
    const fs::path out = exported(format);
    for (const char* name : RemovingRun::kNames) {
      const char* end = std::string(format) == "vtu" && std::string(name) == "jelly" ? "vtu" : "vtp";
      const std::string there = text_of(out / fmt::format("{}_00002.{}", name, end)),
                        gone = text_of(out / fmt::format("{}_00003.{}", name, end));
      EXPECT_EQ(there.find("NumberOfPoints=\"0\""), std::string::npos) << format << " " << name;
      EXPECT_NE(gone.find("NumberOfPoints=\"0\""), std::string::npos) << format << " " << name;
      for (const char* cells : {"NumberOfLines", "NumberOfVerts", "NumberOfPolys", "NumberOfCells"})
        EXPECT_TRUE(gone.find(cells) == std::string::npos ||
                    gone.find(fmt::format("{}=\"0\"", cells)) != std::string::npos)
            << format << " " << name << " " << cells;
    }
  }
}

TEST_F(RemovedBodies, AreNoObjectsInObjAndHaveNoVerticesInPly) {
  const fs::path obj = exported("obj"), ply = exported("ply");
  const std::string there = text_of(obj / "frame_00002.obj"), gone = text_of(obj / "frame_00003.obj");
  for (const char* name : RemovingRun::kNames) {
    EXPECT_NE(there.find(fmt::format("o {}\n", name)), std::string::npos) << name;
    EXPECT_EQ(gone.find(fmt::format("o {}\n", name)), std::string::npos) << name;
    const std::string none = text_of(ply / fmt::format("{}_00003.ply", name));
    EXPECT_NE(none.find("element vertex 0\n"), std::string::npos) << name;
    EXPECT_EQ(none.find("element face"), std::string::npos) << name;
    EXPECT_EQ(none.find("element edge"), std::string::npos) << name;
    EXPECT_TRUE(none.ends_with("end_header\n")) << name;
  }
  EXPECT_NE(gone.find("o floor\n"), std::string::npos);
  EXPECT_EQ(gone.find("\nl "), std::string::npos) << "no lines between vertices that are not there";
  EXPECT_EQ(gone.find("\np "), std::string::npos);
}

TEST_F(RemovedBodies, HaveNoGridInXdmfAndAreMarkedInNpz) {
  const std::string xdmf = text_of(exported("xdmf") / "run.xdmf");
  const std::size_t gone = xdmf.find("<Grid Name=\"frame 3\"");
  ASSERT_NE(gone, std::string::npos);
  for (const char* name : RemovingRun::kNames) {
    const std::string grid = fmt::format("<Grid Name=\"{}\"", name);
    EXPECT_LT(xdmf.find(grid), gone) << name;
    EXPECT_EQ(xdmf.find(grid, gone), std::string::npos) << name;
  }
  const std::string npz = text_of(exported("npz") / "run.npz");
  EXPECT_NE(npz.find("frames/present.npy"), std::string::npos);
  const int code = testing::run_python("numpy", R"(
import sys, numpy
run = numpy.load(sys.argv[1])
present = run["frames/present"]
assert present.shape == (5, len(run["bodies/name"])), present.shape
assert present[:3].all() and present[:, 0].all() and not present[3:, 1:].any(), present
)",
                                       (made_.path / "out_npz/run.npz").string(), made_.path);
  EXPECT_NE(code, 1);
}

nlohmann::json gltf_of(const fs::path& folder) {
  const std::string glb = text_of(folder / "run.glb");
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  return nlohmann::json::parse(glb.substr(20, length));
}

TEST_F(RemovedBodies, LoseTheirSizeAtOnceInGltf) {
  const nlohmann::json gltf = gltf_of(exported("gltf"));
  for (const char* name : RemovingRun::kNames) {
    bool found = false;
    for (const auto& channel : gltf["animations"][0]["channels"]) {
      const auto& node = gltf["nodes"][channel["target"]["node"].get<std::size_t>()];
      const auto& sampler = gltf["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()];
      const auto& times = gltf["accessors"][sampler["input"].get<std::size_t>()];
      if (node["name"].get<std::string>().rfind(name, 0) != 0) continue;
      if (channel["target"]["path"] == "scale") {
        found = true;
        EXPECT_EQ(sampler["interpolation"], "STEP") << name;
        EXPECT_LE(times["max"][0].get<double>(), 0.3 + 1e-6) << name;
      } else {
        EXPECT_NEAR(times["max"][0].get<double>(), 0.2, 1e-6) << name << " moves only while it is there";
      }
    }
    EXPECT_TRUE(found) << name;
  }
}

TEST_F(RemovedBodies, TimesInGltfAreThoseOfTheRun) {
  const nlohmann::json gltf = gltf_of(exported("gltf", "1:2"));
  ASSERT_FALSE(gltf["animations"].empty());
  for (const auto& sampler : gltf["animations"][0]["samplers"]) {
    const auto& times = gltf["accessors"][sampler["input"].get<std::size_t>()];
    EXPECT_NEAR(times["min"][0].get<double>(), 0.1, 1e-6);
    EXPECT_NEAR(times["max"][0].get<double>(), 0.2, 1e-6);
  }
}

TEST_F(RemovedBodies, EveryFormatTakesFramesThatBeginWhenTheyAreGone) {
  for (const char* format : {"vtk", "vtu", "xdmf", "obj", "ply", "gltf", "usda", "npz"})
    for (const char* frames : {"3:4", "4", "2:3"}) EXPECT_NO_THROW(exported(format, frames)) << format << " " << frames;
}

}  // namespace
}  // namespace brim::export_removed_test
