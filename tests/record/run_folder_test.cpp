#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "support/recorded_fall.h"

/// What happens to folders and the files of others.
namespace brim::run_folder_test {
namespace {

namespace fs = std::filesystem;
using testing::kScene;
using testing::Run;

TEST_F(Run, AFirstStepThatIsRefusedLeavesNoFolder) {
  std::string far = kScene;
  far.replace(far.find("[0, 0, 0.51]"), 12, "[1e10, 0, 0.49]");
  const Scene scene = parse_scene(far);
  World world = build_world(scene);
  EXPECT_THROW(record_run(world, plan(scene, at("run")), {}), InputError);
  EXPECT_FALSE(fs::exists(folder_ / "run"));
  // A folder of somebody's stays, without the files of the run.
  fs::create_directories(folder_ / "empty");
  World again = build_world(scene);
  EXPECT_THROW(record_run(again, plan(scene, at("empty")), {}), InputError);
  EXPECT_TRUE(fs::is_empty(folder_ / "empty"));
}

TEST_F(Run, FoldersWithOtherFilesAreNeverTouched) {
  const Scene scene = parse_scene(kScene);
  World world = build_world(scene);
  fs::create_directories(folder_ / "mine");
  std::ofstream(folder_ / "mine/letter.txt") << "dear";
  EXPECT_THROW(record_run(world, plan(scene, at("mine")), {}), InputError);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "mine"), fs::directory_iterator()), 1);

  record_run(world, plan(scene, at("run")), {});
  EXPECT_THROW(record_run(world, plan(scene, at("run")), {}), InputError) << "an old run needs force";
  std::ofstream(folder_ / "run/letter.txt") << "dear";
  RunPlan again = plan(scene, at("run"));
  again.force = true;
  World fresh = build_world(scene);
  EXPECT_NO_THROW(record_run(fresh, again, {}));
  EXPECT_TRUE(fs::exists(folder_ / "run/letter.txt"));
}

}  // namespace
}  // namespace brim::run_folder_test
