#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "support/made_run.h"
#include "support/recorded_fall.h"
#include "support/version_1_run.h"

/// Runs of earlier versions.
namespace brim::old_version_test {
namespace {

using testing::kScene;
using testing::Run;
using testing::same_bits;

TEST_F(Run, AnOlderRunReadsZerosForWhatItsVersionDidNotRecordAndCanBeGoneOnWith) {
  const Scene scene = parse_scene(kScene);
  {
    World world = build_world(scene);
    record_run(world, plan(scene, at("run")), [](const RunProgress& p) { return p.frame < 7; });
  }
  const char* const kForget =
      "import sys, h5py\nf = h5py.File(sys.argv[1], 'a')\ndel f['series/sweeps'], f['series/voxels']\n";
  if (testing::run_python("h5py", kForget, "'" + at("run/run.h5") + "'", folder_) < 0)
    GTEST_SKIP() << "python3 without h5py";
  std::int64_t frames = 0;
  {
    const RunReader run(at("run"));
    frames = run.frames();
    ASSERT_GT(frames, 3);
    EXPECT_EQ(run.series("voxels"), std::vector<double>(static_cast<std::size_t>(frames), 0.0));
    EXPECT_EQ(run.report(3).sweeps, 0);
    EXPECT_GT(run.report(3).tiles, 0);
    EXPECT_THROW(run.series("no_such_series"), InputError);
  }
  World world = build_world(scene);
  record_run(world, resumed(scene, at("run")), {});
  const RunReader run(at("run"));
  const std::vector<double> voxels = run.series("voxels");
  ASSERT_EQ(voxels.size(), 13u);
  EXPECT_EQ(voxels[static_cast<std::size_t>(frames) - 1], 0.0);
  EXPECT_GT(voxels.back(), 0.0);
}

TEST_F(Run, ARunOfTheFirstVersionReadsAlikeAndIsGoneOnWithToTheSameBits) {
  const Scene scene = parse_scene(kScene);
  World straight = build_world(scene);
  record_run(straight, plan(scene, at("straight")), {});
  {
    World first = build_world(scene);
    record_run(first, plan(scene, at("run")), [](const RunProgress& p) { return p.frame < 7; });
  }
  testing::write_version_1(at("run"), at("old"));
  {
    const RunReader now(at("run")), old(at("old"));
    EXPECT_EQ(old.format_version(), 1);
    EXPECT_EQ(now.format_version(), 2);
    ASSERT_EQ(now.frames(), old.frames());
    for (std::int64_t f = 0; f < now.frames(); ++f)
      for (int b = 0; b < 3; ++b) {
        EXPECT_EQ(now.positions(b, f), old.positions(b, f));
        EXPECT_EQ(now.triangles(b, f), old.triangles(b, f));
        EXPECT_EQ(now.still(b), old.still(b));
      }
  }
  World world = build_world(scene);
  EXPECT_EQ(record_run(world, resumed(scene, at("old")), {}).end, RunEnd::Completed);
  EXPECT_EQ(world.hash(), straight.hash());
  const RunReader a(at("straight")), b(at("old"));
  EXPECT_EQ(b.format_version(), 2);
  ASSERT_EQ(a.frames(), b.frames());
  for (std::int64_t f = 0; f < a.frames(); ++f) {
    EXPECT_TRUE(same_bits(a.state(f).q, b.state(f).q)) << f;
    EXPECT_EQ(a.positions(2, f), b.positions(2, f)) << f;
    EXPECT_EQ(a.contacts(f).size(), b.contacts(f).size()) << f;
    EXPECT_EQ(a.pairs(f).size(), b.pairs(f).size()) << f;
  }
}

}  // namespace
}  // namespace brim::old_version_test
