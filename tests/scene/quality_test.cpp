#include <gtest/gtest.h>

#include <string>

#include "brim/core/error.h"
#include "brim/scene/scene.h"

/// One word for how sharply a world is solved.
namespace brim::quality_test {
namespace {

WorldOptions options(const std::string& world) {
  const std::string text = R"({"brim": 1, "name": "test", "frames": 1, "world": {)" + world +
                           R"(}, "bodies": [{"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}}]})";
  return parse_scene(text, "scene.json").world;
}

TEST(Quality, SaysNothingByItself) {
  const WorldOptions plain, read = options(""), named = options(R"("quality": "default")");
  for (const WorldOptions& o : {read, named}) {
    EXPECT_EQ(o.max_motion_voxels, plain.max_motion_voxels);
    EXPECT_EQ(o.cg_tolerance, plain.cg_tolerance);
    EXPECT_EQ(o.max_passes, plain.max_passes);
    EXPECT_EQ(o.constraint_tolerance, plain.constraint_tolerance);
    EXPECT_EQ(o.constraint_sweeps, plain.constraint_sweeps);
  }
}

TEST(Quality, IsSharperFromDraftToFine) {
  const WorldOptions draft = options(R"("quality": "draft")"), fine = options(R"("quality": "fine")"), usual;
  EXPECT_GT(draft.max_motion_voxels, usual.max_motion_voxels);
  EXPECT_GT(usual.max_motion_voxels, fine.max_motion_voxels);
  EXPECT_GT(draft.cg_tolerance, usual.cg_tolerance);
  EXPECT_GT(usual.cg_tolerance, fine.cg_tolerance);
  EXPECT_LT(draft.max_passes, usual.max_passes);
  EXPECT_LT(usual.max_passes, fine.max_passes);
  EXPECT_LT(draft.constraint_sweeps, usual.constraint_sweeps);
  EXPECT_LT(usual.constraint_sweeps, fine.constraint_sweeps);
}

TEST(Quality, AKeyThatIsGivenCountsBeforeIt) {
  const WorldOptions o = options(R"("quality": "draft", "cg_tolerance": 1e-5)");
  EXPECT_EQ(o.cg_tolerance, 1e-5);
  EXPECT_EQ(o.max_passes, 2);
}

TEST(Quality, OtherWordsAreRefused) { EXPECT_THROW(options(R"("quality": "best")"), InputError); }

}  // namespace
}  // namespace brim::quality_test
