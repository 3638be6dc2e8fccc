// Stress of elastic solids as VTK reads it.
#include <gtest/gtest.h>

#include <filesystem>

#include "brim/core/error.h"
#include "brim/record/export/export.h"
#include "brim/record/runner.h"
#include "brim/scene/scene.h"
#include "support/made_run.h"

namespace brim::export_stress_test {
namespace {

namespace fs = std::filesystem;

TEST(ExportStress, VtkReadsThatOfPulledSolidsAndTheSurfacesOfTheRest) {
  const testing::MadeRun lends(1);  // a folder
  const Scene scene = parse_scene(R"({"brim": 1, "name": "pulled", "frames": 1, "world": {"gravity": [0, 0, 0]},
    "bodies": [{"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": 0.1}},
    {"kind": "finite_elements", "name": "bar", "shape": {"kind": "box", "size": [0.4, 0.2, 0.2]}, "lattice_spacing": 0.1,
     "young_modulus": 1e5, "poisson_ratio": 0, "velocity": [0, 0, 3], "transform": {"position": [2, 0, 0]}},
    {"kind": "meshless", "name": "jelly", "shape": {"kind": "box", "size": [0.4, 0.4, 0.4]}, "frame_spacing": 0.1,
     "young_modulus": 1e5, "poisson_ratio": 0, "transform": {"position": [4, 0, 0]}}]})");
  World world = build_world(scene);
  State state = world.state();
  std::size_t first = world.q(0).size();
  for (const int b : {1, 2}) {
    for (std::size_t i = 0; i < world.q(b).size(); i += 3) state.q[first + i] *= 1.01;
    first += world.q(b).size();
  }
  world.set_state(state);
  RunPlan plan;
  plan.folder = (lends.path / "pulled").string();
  plan.info = {scene.name, scene.text, scene.frame_time(), scene.steps_per_frame};
  plan.frames = plan.scene_frames = scene.frames;
  record_run(world, plan, {});
  const RunReader run(plan.folder);
  const fs::path out = lends.path / "out";
  EXPECT_THROW(export_run(run, {.format = "vtu", .folder = out.string()}), InputError) << "without a world";
  export_run(run, {.format = "vtu", .folder = out.string(), .frames = "0"}, [&](std::int64_t f) -> const World& {
    world.set_state(run.state(f));
    return world;
  });
  EXPECT_TRUE(fs::exists(out / "ball_00000.vtp") || fs::exists(out / "ball.vtp"));
  const int code = testing::run_python("numpy, vtk", R"(
import sys, vtk, numpy as np
from vtk.util.numpy_support import vtk_to_numpy as N
def read(name):
    r = vtk.vtkXMLUnstructuredGridReader(); r.SetFileName(f'{sys.argv[1]}/{name}'); r.Update(); return r.GetOutput()
bar = read('bar_00000.vtu'); d = bar.GetCellData(); n = bar.GetNumberOfCells()
assert n > 20 and {bar.GetCellType(i) for i in range(n)} == {vtk.VTK_TETRA}
assert np.allclose(N(d.GetArray('stress')), [1e3, 0, 0, 0, 0, 0], atol=1), N(d.GetArray('stress'))
assert np.allclose(N(d.GetArray('von_mises')), 1e3, atol=1)
assert np.allclose(N(d.GetArray('strain')), [0.5 * (1.01**2 - 1), 0, 0, 0, 0, 0], atol=1e-6)
assert np.allclose(N(d.GetArray('volume_ratio')), 1.01, atol=1e-6)
assert np.allclose(N(bar.GetPointData().GetArray('velocity')), [0, 0, 3])
x = N(bar.GetPoints().GetData()); assert np.allclose([x[:, 0].min(), x[:, 0].max()], [1.8 * 1.01, 2.2 * 1.01])
jelly = read('jelly_00000.vtu'); d = jelly.GetPointData(); n = jelly.GetNumberOfCells()
assert n == jelly.GetNumberOfPoints() > 20 and {jelly.GetCellType(i) for i in range(n)} == {vtk.VTK_VERTEX}
assert np.allclose(N(d.GetArray('von_mises')), 1e3, atol=1)
)",
                                       "'" + out.string() + "'", lends.path);
  if (code < 0) GTEST_SKIP() << "python3 without vtk";
  EXPECT_EQ(code, 0);
}

}  // namespace
}  // namespace brim::export_stress_test
