#include <gtest/gtest.h>

#include "brim/core/error.h"
#include "brim/record/h5.h"
#include "support/recorded_fall.h"

/// Files that are damaged, or no runs at all.
namespace brim::damaged_run_test {
namespace {

namespace fs = std::filesystem;
using testing::kScene;
using testing::Run;

TEST_F(Run, DamagedFilesAreRefusedWithTheNameOfWhatIsWrong) {
  const Scene scene = parse_scene(kScene);
  World world = build_world(scene);
  record_run(world, plan(scene, at("run")), {});
  using Shape = std::vector<std::uint64_t>;
  const std::vector<char> zeros(1 << 22, 0);
  const std::vector<std::int64_t> ones(100000, 1), large(100000, 123456789012);
  std::vector<std::int64_t> rising;
  for (std::int64_t i = 0; i < 20; ++i) rising.push_back(i << 40);
  struct Damage {
    const char* path;
    h5::Type type;
    Shape shape;
    const void* data;
  };
  using enum h5::Type;
  const std::vector<Damage> damages = {{"/meshes/triangles", Int32, {12, 4000}, zeros.data()},
                                       {"/meshes/triangles", Float32, {12, 3}, zeros.data()},
                                       {"/meshes/vertices", Float64, {5}, zeros.data()},
                                       {"/meshes/first_vertex", Int64, {3}, large.data()},
                                       {"/poses/mesh", Int32, {3}, large.data()},
                                       {"/poses/mesh", Int32, {9000}, zeros.data()},
                                       {"/poses/rotation", Float64, {13, 1, 9}, zeros.data()},
                                       {"/poses/translation", Float64, {13, 9}, zeros.data()},
                                       {"/bodies/q_offset", Int64, {3}, large.data()},
                                       {"/bodies/v_size", Int64, {3}, large.data()},
                                       {"/bodies/pieces", Int64, {3}, large.data()},
                                       {"/bodies/vertices", Int64, {3}, ones.data()},
                                       {"/bodies/first_position", Int64, {3}, zeros.data()},
                                       {"/parts/body", Int64, {3}, large.data()},
                                       {"/frames/count", Int64, {1}, large.data()},
                                       {"/frames/q", Float64, {13, 2}, zeros.data()},
                                       {"/contacts/offset", Int64, {14}, rising.data()},
                                       {"/contacts/position", Float32, {20000, 30}, zeros.data()},
                                       {"/contacts/pair", Int32, {20000, 2}, large.data()},
                                       {"/contacts/pair", Float32, {20000, 2}, zeros.data()},
                                       {"/memory/offset", Int64, {14}, rising.data()},
                                       {"/motion/center", Float64, {13, 3, 30}, zeros.data()},
                                       {"/series/wall", Float64, {2}, zeros.data()},
                                       {"/display/first_triangle", Int64, {4}, large.data()}};
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.path);
    fs::remove_all(folder_ / "bad");
    fs::copy(folder_ / "run", folder_ / "bad");
    {
      h5::File file(at("bad/run.h5"), h5::File::Mode::Write);
      file.remove(damage.path);
      file.write(damage.path, damage.type, damage.shape, damage.data);
    }
    const auto read_all = [&] {
      const RunReader run(at("bad"));
      run.series("wall");
      for (std::int64_t f = 0; f < run.frames(); ++f) {
        run.state(f), run.report(f), run.samples(f), run.contacts(f), run.tiles(f);
        for (std::size_t b = 0; b < run.bodies().size(); ++b) run.positions(static_cast<int>(b), f);
      }
    };
    try {
      read_all();
      ADD_FAILURE() << "was read";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(at("bad")), std::string::npos) << error.what();
    }
    World fresh = build_world(scene);
    RunPlan p = plan(scene, at("bad"));
    p.resume = true;
    p.frames = 14;
    // The positions that resuming does not need may be anything; nothing may crash.
    try {
      record_run(fresh, p, {});
    } catch (const InputError&) {
    }
  }
}

TEST_F(Run, OtherFilesAreNotTakenForRuns) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "a.h5") << "not HDF5 at all";
  EXPECT_THROW(RunReader{at("a.h5")}, InputError);
  EXPECT_THROW(RunReader{at("none")}, InputError);
  EXPECT_THROW(RunReader{folder_.string()}, InputError);
}

}  // namespace
}  // namespace brim::damaged_run_test
