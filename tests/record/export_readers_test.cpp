// Each format is read back by somebody else's reader (VTK, meshio, NumPy, OpenVDB) and held to the
// formula of tests/support/made_run.h. Where a reader is not installed, its test is skipped.
#include <gtest/gtest.h>

#include <filesystem>

#include "brim/core/error.h"
#include "brim/io/volume_reader.h"
#include "brim/record/export/export.h"
#include "brim/record/export/format.h"
#include "support/made_run.h"
#include "support/worlds.h"

namespace brim::export_readers_test {
namespace {

namespace fs = std::filesystem;
using testing::MadeRun;

/// The formula of MadeRun::at in Python, and the frames that are exported below.
const std::string kFormula = R"(
import sys, math, numpy as np
folder = sys.argv[1]
FRAMES = [1, 3, 5]
CORNER = [(0,0,0),(1,0,0),(0,1,0),(0,0,1)]
def at(b, i, f):
    t = 0.1 * f
    if b == 0: return (5 if i % 2 else -5, 5 if i // 2 else -5, 0)
    x, y, z = CORNER[i] if b < 3 else (0, 0, 0)
    if b == 1: return (math.cos(t)*x - math.sin(t)*y + t, math.sin(t)*x + math.cos(t)*y, z + 2*t)
    if b == 2: return (x*(1+t) + 3, y, z)
    if b == 3: return (0.5*i, -2, t*i)
    return (0.25*i, 2, t)
COUNT = [4, 4, 4, 4, 5]
NAMES = ['floor', 'ball', 'ball.1', 'rod', 'grains']
def body(b, f): return np.array([at(b, i, f) for i in range(COUNT[b])])
def near(a, b, what):
    a, b = np.asarray(a, float), np.asarray(b, float)
    assert a.shape == b.shape, (what, a.shape, b.shape)
    assert np.abs(a - b).max(initial=0) < (1e-5 if what == 'velocity' else 2e-6), (what, a, b)
SOLID = [[0,2,1],[0,1,3],[0,3,2],[1,2,3]]
)";

class Readers : public ::testing::Test {
 protected:
  /// Exports frames 1, 3 and 5 of a made run and has a script look at them.
  void read_back(const char* format, const std::string& modules, const std::string& script) {
    const MadeRun made(7);
    const fs::path out = made.path / "out";
    const RunReader run(made.folder());
    export_run(run, {.format = format, .folder = out.string(), .frames = "1:5:2"});
    const int code = testing::run_python(modules, kFormula + script, "'" + out.string() + "'", made.path);
    if (code < 0) GTEST_SKIP() << "python3 without " << modules;
    EXPECT_EQ(code, 0);
  }
};

TEST_F(Readers, VtkReadsItsOwnFormatOverTime) {
  read_back("vtk", "numpy, vtk", R"(
import vtk, xml.etree.ElementTree as E
from vtk.util.numpy_support import vtk_to_numpy as N
sets = E.parse(folder + '/run.pvd').getroot().findall('Collection/DataSet')
assert len(sets) == 3 * 6, len(sets)
seen = 0
for s in sets:
    f = round(float(s.get('timestep')) / 0.1)
    r = vtk.vtkXMLPolyDataReader(); r.SetFileName(folder + '/' + s.get('file')); r.Update(); o = r.GetOutput()
    field = lambda name: N(o.GetPointData().GetArray(name))
    points = N(o.GetPoints().GetData())
    if s.get('name') == 'contacts':
        n = min(f, 2)
        near(points, [(c, 0, 0) for c in range(n)], 'contacts')
        near(field('force'), [(0, 0, -f)] * n, 'force')
        near(field('friction'), [(0.5, 0, 0)] * n, 'friction')
        near(field('parts'), [(0, 1), (0, 4)][:n], 'parts')
        assert o.GetNumberOfVerts() == n
        continue
    b = NAMES.index(s.get('name'))
    near(points, body(b, f), s.get('name'))
    assert [o.GetNumberOfVerts(), o.GetNumberOfLines(), o.GetNumberOfPolys()] == [[0,0,2],[0,0,4],[0,0,4],[0,3,0],[5,0,0]][b]
    if b == 1: near(N(o.GetPolys().GetConnectivityArray()).reshape(-1, 3), SOLID, 'triangles')
    # Of the grains as recorded, of the others differences of positions: this run has no scene and no twists.
    near(field('velocity'), (body(b, f + 1) - body(b, f - 1)) / 0.2, 'velocity')
    if b == 4: near(field('radius'), [0.125] * 5, 'radius')
    seen += 1
assert seen == 15
)");
}

TEST_F(Readers, MeshioReadsEveryGridOfXdmf) {
  // meshio knows no collections: each grid is handed to it in a file of its own, as it stands.
  read_back("xdmf", "numpy, meshio, h5py", R"(
import meshio, xml.etree.ElementTree as E
run = E.parse(folder + '/run.xdmf').getroot().find('Domain/Grid')
assert run.get('CollectionType') == 'Temporal'
assert [round(float(g.find('Time').get('Value')) / 0.1) for g in run.findall('Grid')] == FRAMES
for f, frame in zip(FRAMES, run.findall('Grid')):
    grids = {g.get('Name'): g for g in frame.findall('Grid')}
    assert list(grids) == NAMES + ['contacts']
    for name, grid in grids.items():
        root = E.Element('Xdmf', Version='3.0'); E.SubElement(root, 'Domain').append(grid)
        E.ElementTree(root).write(folder + '/one.xdmf')
        m = meshio.read(folder + '/one.xdmf')
        n = min(f, 2)
        if name == 'contacts':
            near(m.points, [(c, 0, 0) for c in range(n)], name)
            near(m.point_data['force'], [(0, 0, -f)] * n, 'force'); near(m.point_data['part_b'], [1, 4][:n], 'part')
            continue
        b = NAMES.index(name)
        near(m.points, body(b, f), name)
        if b == 1: near(m.cells[0].data, SOLID, 'triangles')
        near(m.point_data['velocity'], (body(b, f + 1) - body(b, f - 1)) / 0.2, 'velocity')
)");
}

TEST_F(Readers, VtkReadsObj) {
  read_back("obj", "numpy, vtk", R"(
import vtk
from vtk.util.numpy_support import vtk_to_numpy as N
for f in FRAMES:
    r = vtk.vtkOBJReader(); r.SetFileName(folder + '/frame_%05d.obj' % f); r.Update(); o = r.GetOutput()
    near(N(o.GetPoints().GetData()), np.concatenate([body(b, f) for b in range(5)]), 'points')
    assert (o.GetNumberOfVerts(), o.GetNumberOfLines(), o.GetNumberOfPolys()) == (5, 3, 10)
    near(N(o.GetPolys().GetConnectivityArray()).reshape(-1, 3)[2:6], np.array(SOLID) + 4, 'ball')
    near(N(o.GetLines().GetConnectivityArray()), [12, 13, 13, 14, 14, 15], 'rod')
)");
}

TEST_F(Readers, MeshioReadsPly) {
  read_back("ply", "numpy, meshio", R"(
import meshio
for f in FRAMES:
    for b in (0, 1, 2, 4):
        m = meshio.read(folder + ('/floor.ply' if b == 0 else '/%s_%05d.ply' % (NAMES[b], f)))
        near(m.points, body(b, f), NAMES[b])
        if b == 1: near(m.cells[0].data, SOLID, 'triangles')
        if b == 4:
            near(m.point_data['vz'], [1] * 5, 'velocity'); near(m.point_data['pscale'], [0.125] * 5, 'radius')
    n = min(f, 2)
    c = meshio.read(folder + '/contacts_%05d.ply' % f)
    near(c.point_data['force_z'], [-f] * n, 'force'); near(c.point_data['nz'], [-1] * n, 'direction')
    near(c.point_data['part_b'], [1, 4][:n], 'part')
)");
}

TEST_F(Readers, VtkReadsTheEdgesOfPlyAsPoints) {
  read_back("ply", "numpy, vtk", R"(
import vtk
from vtk.util.numpy_support import vtk_to_numpy as N
for f in FRAMES:
    r = vtk.vtkPLYReader(); r.SetFileName(folder + '/rod_%05d.ply' % f); r.Update()
    near(N(r.GetOutput().GetPoints().GetData()), body(3, f), 'rod')
)");
}

TEST_F(Readers, VtkPlaysGltf) {
  read_back("gltf", "numpy, vtk", R"(
import vtk
from vtk.util.numpy_support import vtk_to_numpy as N
r = vtk.vtkGLTFReader(); r.SetFileName(folder + '/run.glb'); r.SetApplyDeformationsToGeometry(True); r.UpdateInformation()
assert r.GetNumberOfAnimations() == 1
assert abs(r.GetAnimationDuration(0) - 0.5) < 1e-6
r.SetFrameRate(100); r.EnableAnimation(0); r.UpdateInformation()
def leaves(data):
    if isinstance(data, vtk.vtkMultiBlockDataSet):
        for i in range(data.GetNumberOfBlocks()): yield from leaves(data.GetBlock(i))
    elif data is not None: yield data
for f in FRAMES:
    r.UpdateTimeStep(0.1 * f)
    found = [N(d.GetPoints().GetData()) for d in leaves(r.GetOutput())]
    assert len(found) == 5, len(found)
    for b, points in enumerate(found):
        x, y, z = points.T   # y up
        got = {tuple(p) for p in np.round(np.stack([x, -z, y], 1).astype(float), 4) + 0.0}
        want = {tuple(p) for p in np.round(body(b, f), 4) + 0.0}
        assert got == want, (NAMES[b], f, got, want)
)");
}

TEST_F(Readers, NumpyReadsNpz) {
  read_back("npz", "numpy", R"(
z = np.load(folder + '/run.npz')
assert list(z['bodies/name']) == NAMES and list(z['parts/body']) == [0, 1, 2, 3, 4]
near(z['frames/time'], [0.1, 0.3, 0.5], 'time')
assert z['frames/index'].tolist() == FRAMES and z['frames/step'].tolist() == FRAMES
near(z['display/0/positions'], [body(0, 0)], 'floor')
for b in (1, 2, 3, 4): near(z['display/%d/positions' % b], [body(b, f) for f in FRAMES], NAMES[b])
near(z['bodies/1/triangles'], SOLID, 'triangles')
assert z['contacts/offset'].tolist() == [0, 1, 3, 5]
near(z['contacts/force'][:, 2], [-1, -3, -3, -5, -5], 'force')
assert z['contacts/pair'].dtype == np.int32 and z['frames/v'].dtype == np.float64
assert z['memory/value'].shape == (0,) and z['series/worst_overlap'].shape == (3,)
import zipfile
assert zipfile.ZipFile(folder + '/run.npz').testzip() is None
)");
}

/// Densities of a ball of radius 0.5 at (0.2, −0.3, 0.6) and of a floor, in the VDB file of a frame.
class ReadersOfDensities : public ::testing::Test {
 protected:
  void SetUp() override {
    bool there = false;
    for (const exporting::Format& f : exporting::formats()) there = there || f.name == std::string_view("vdb");
    if (!there) GTEST_SKIP() << "built without OpenVDB";
  }

  void write(double voxel_size) {
    World world(testing::options_at(0.1));
    world.add(testing::ground(0.5));
    world.add(testing::ball("ball", {.x = Vec3(0.2, -0.3, 0.6)}, 0.5, 0.5));
    const RunReader run(made_.folder());
    export_run(run,
               {.format = "vdb",
                .folder = out_.string(),
                .frames = "1",
                .bodies = {"floor", "ball"},
                .voxel_size = voxel_size},
               [&](std::int64_t) -> const World& { return world; });
  }

  const MadeRun made_{2};  // lends its frames; the densities come from a world of their own
  const fs::path out_ = made_.path / "out";
};

TEST_F(ReadersOfDensities, OpenVdbReadsTheDensityOfABallAndAFloor) {
  write(0.1);
  const int code = testing::run_python("numpy, pyopenvdb", R"(
import sys, math, numpy as np, pyopenvdb as vdb
grids, about = vdb.readAll(sys.argv[1] + '/frame_00001.vdb')
grids = {g.name: g for g in grids}
assert grids['ball.1'].activeVoxelCount() == 0  # the world has no such body
assert abs(about['time'] - 0.1) < 1e-12
g = grids['ball']
assert g.gridClass == 'fog volume' and g.transform.voxelSize() == (0.1, 0.1, 0.1)
a = g.getConstAccessor()
total = 0.0
for i in range(-8, 12):
    for j in range(-12, 8):
        for k in range(-4, 16):
            x, y, z = g.transform.indexToWorld((i, j, k))
            d = math.dist((x, y, z), (0.2, -0.3, 0.6)) - 0.5
            s = min(1, max(0, 0.5 - d / 0.3))
            near = a.getValue((i, j, k))
            assert abs(near - s * s * (3 - 2 * s)) < 1e-6, (i, j, k, near, d)
            total += near * 1e-3
assert abs(total / (4 / 3 * math.pi * 0.125) - 1) < 0.06, total   # the ramp adds (w/R)²-ish to a ball
floor = grids['floor'].getConstAccessor()
assert abs(floor.getValue((2, -3, 0)) - 0.5) < 1e-6 and floor.getValue((2, -3, 3)) == 0 and floor.getValue((2, -3, -2)) == 1
)",
                                       "'" + out_.string() + "'", made_.path);
  if (code < 0) GTEST_SKIP() << "python3 without pyopenvdb";
  EXPECT_EQ(code, 0);
}

/// brim reads what it wrote: a ball as a volume of densities.
TEST_F(ReadersOfDensities, BrimReadsTheVolumeOfABallFromOpenVdb) {
  write(0.05);
  const std::string file = (out_ / "frame_00001.vdb").string();
  const VoxelImage image = read_volume(read_volume_info(file, "ball"));
  EXPECT_TRUE(image.axes.isApprox(0.05 * Mat3::Identity()));
  double mass = 0.0;
  Vec3 moment = Vec3::Zero();
  for (int k = 0, n = 0; k < image.size.z(); ++k)
    for (int j = 0; j < image.size.y(); ++j)
      for (int i = 0; i < image.size.x(); ++i, ++n) {
        mass += image.values[n] * 1.25e-4;
        moment += image.values[n] * 1.25e-4 * (image.origin + image.axes * Vec3(i, j, k));
      }
  EXPECT_NEAR(mass, 4.0 / 3.0 * 3.14159265 * 0.125, 0.02 * mass);
  EXPECT_NEAR((moment / mass - Vec3(0.2, -0.3, 0.6)).norm(), 0.0, 1e-3);
  EXPECT_GT(read_volume_info(file, "floor").size.x(), image.size.x());
  try {
    read_volume_info(file, "cube");
    FAIL() << "there is no such grid";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("called 'cube'; there are: "), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("'ball' (float)"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace brim::export_readers_test
