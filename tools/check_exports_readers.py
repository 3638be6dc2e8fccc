"""The readers of tools/check_exports.py: each opens an export with another program and compares it with run.h5."""

import json
import os
import pathlib
import shutil
import subprocess
import xml.etree.ElementTree as xml
from dataclasses import dataclass
from functools import cache
from typing import Callable

import with_numpy

with_numpy.need("numpy", "h5py")
import numpy as np  # noqa: E402

from run_file import RunFile  # noqa: E402

PYTHON = "/usr/bin/python3"  # the one for which Debian's packages are installed
TOOLS = pathlib.Path(__file__).resolve().parent


@dataclass
class Recorded:
    """A body as run.h5 has it."""
    name: str
    display: str
    still: bool
    positions: dict  # frame -> (vertices, 3)
    cells: dict  # frame -> number of triangles or lines
    changing: bool = False  # another surface in every frame
    posed: bool = False  # its poses are recorded instead of its positions


class Truth:
    """What was recorded, of a few frames."""

    def __init__(self, run):
        with RunFile(run / "run.h5") as recorded:
            times = recorded.file["frames/time"][:recorded.frames]
            stride = max(1, (len(times) - 1) // 2)
            self.frames = list(range(0, len(times), stride))[:3]
            self.frame_range = f"{self.frames[0]}:{self.frames[-1]}:{stride}"
            self.times = {f: float(times[f]) for f in self.frames}
            self.bodies = [self.body(recorded, b) for b in recorded.bodies]
            offset = recorded.file["contacts/offset"][:]
            self.contacts = {f: int(offset[f + 1] - offset[f]) for f in self.frames}

    def body(self, recorded, b):
        return Recorded(b.name, b.display, recorded.still(b), {f: recorded.positions(b, f) for f in self.frames},
                        {f: len(recorded.triangles(b, f)) for f in self.frames}, b.changing,
                        recorded.version > 1 and int(b.attrs["pieces"]) > 0)

    def named(self, name):
        return next((b for b in self.bodies if b.name == name), None)


def same(found, wanted, what, tolerance=2e-5):
    """Lists of points that agree in order."""
    found, wanted = np.asarray(found, float).reshape(-1, 3), np.asarray(wanted, float).reshape(-1, 3)
    assert found.shape == wanted.shape, f"{what}: {len(found)} points instead of {len(wanted)}"
    off = np.abs(found - wanted).max(initial=0)
    assert off <= tolerance, f"{what}: a point is off by {off:.2g} m"


def same_set(found, wanted, what, tolerance=2e-4):
    """Lists of points that agree whatever their order and however often each stands there."""
    found, wanted = np.asarray(found, float).reshape(-1, 3), np.asarray(wanted, float).reshape(-1, 3)
    assert len(found) > 0 or len(wanted) == 0, f"{what}: no points"

    def cells(points):
        return np.unique(np.floor(points / (10 * tolerance)).astype(np.int64), axis=0)

    def near(points, others):
        known = {tuple(c) for c in cells(others)}
        base = np.floor(points / (10 * tolerance)).astype(np.int64)
        around = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
        return all(any((c[0] + i, c[1] + j, c[2] + k) in known for i, j, k in around) for c in np.unique(base, axis=0))
    assert near(found, wanted), f"{what}: a point that was not recorded"
    assert near(wanted, found), f"{what}: a recorded point is missing"


def found_in(data, key):
    assert key in data, f"nothing of {key.split('@')[0]}"
    return data[key]


def python(script, *arguments):
    """Runs a script in Debian's Python and returns what it saved."""
    result = subprocess.run([PYTHON, "-c", script, *map(str, arguments)], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr.strip().splitlines()[-1] if result.stderr.strip() else "crashed"
    return result.stdout


@cache
def has_module(name):
    return subprocess.run([PYTHON, "-c", f"import {name}"], capture_output=True).returncode == 0


# ---- VTK and meshio ------------------------------------------------------------------------------------------------

VTK = """
import sys, numpy as np, vtk
from vtk.util.numpy_support import vtk_to_numpy as N
found = {}
for i, path in enumerate(sys.argv[3:]):
    reader = getattr(vtk, sys.argv[1])(); reader.SetFileName(path); reader.Update(); o = reader.GetOutput()
    found[f'points{i}'] = np.array(N(o.GetPoints().GetData())) if o.GetNumberOfPoints() else np.zeros((0, 3))
    found[f'cells{i}'] = [o.GetNumberOfVerts(), o.GetNumberOfLines(), o.GetNumberOfPolys()]
    found[f'arrays{i}'] = [o.GetPointData().GetArrayName(k) for k in range(o.GetPointData().GetNumberOfArrays())]
np.savez(sys.argv[2], **found)
"""


def vtk(reader, paths, work):
    """Of each file its points, its numbers of vertices, lines and polygons, and its arrays' names."""
    python(VTK, reader, work / "vtk.npz", *paths)
    data = np.load(work / "vtk.npz")
    return [(data[f"points{i}"], data[f"cells{i}"].tolist(), data[f"arrays{i}"].tolist()) for i in range(len(paths))]


def vtk_reads_vtk(folder, truth, work):
    bodies, contacts = 0, 0
    entries = xml.parse(folder / "run.pvd").getroot().findall("Collection/DataSet")
    read = vtk("vtkXMLPolyDataReader", [folder / e.get("file") for e in entries], work)
    for entry, (points, cells, arrays) in zip(entries, read):
        frame = min(truth.times, key=lambda f: abs(truth.times[f] - float(entry.get("timestep"))))
        body = truth.named(entry.get("name"))
        if body is None:
            assert len(points) == truth.contacts[frame], f"frame {frame}: {len(points)} contacts"
            assert {"force", "friction", "overlap"} <= set(arrays), "contacts without forces"
            contacts += len(points)
            continue
        same(points, body.positions[frame], f"{body.name}, frame {frame}")
        column = {"points": 0, "lines": 1, "triangles": 2}[body.display]
        expected = len(points) if body.display == "points" else body.cells[frame]
        assert cells[column] == expected, f"{body.name}: {cells} cells instead of {expected}"
        bodies += 1
    assert bodies == len(truth.bodies) * len(truth.frames), f"{bodies} data sets of bodies"
    return f"{bodies} data sets of bodies and {contacts} contacts over {len(truth.frames)} frames"


def vtk_reads_obj(folder, truth, work):
    read = vtk("vtkOBJReader", [folder / f"frame_{f:05}.obj" for f in truth.frames], work)
    for f, (points, cells, _) in zip(truth.frames, read):
        same(points, np.concatenate([b.positions[f] for b in truth.bodies]), f"frame {f}")
        triangles = sum(b.cells[f] for b in truth.bodies if b.display == "triangles")
        assert cells[2] == triangles, f"frame {f}: {cells[2]} faces instead of {triangles}"
    return f"{len(points)} points and {triangles} faces in the last of {len(truth.frames)} files"


@cache
def catalogue(folder):
    """Where each body is, by its name: what export.json tells."""
    return {b["name"]: b for b in json.loads((folder / "export.json").read_text())["bodies"]}


def ply_of(folder, body, f):
    file = catalogue(folder)[body.name]["file"]
    return folder / (file % f if "%" in file else file)


def paths_of(folder, body):
    """Of a body within a file: one, or those of its pieces."""
    entry = catalogue(folder)[body.name]
    return [p["path"] for p in entry["pieces"] if "path" in p] or [entry["path"]]


def meshio_reads_ply(folder, truth, work):
    script = """
import sys, numpy as np, meshio
found = {}
for i, path in enumerate(sys.argv[2:]):
    m = meshio.read(path)
    found[f'points{i}'], found[f'cells{i}'] = m.points, sum(len(c.data) for c in m.cells)
np.savez(sys.argv[1], **found)
"""
    # It knows no edges in this format.
    wanted = [(body, f) for f in truth.frames for body in truth.bodies if body.display != "lines"]
    python(script, work / "ply.npz", *(ply_of(folder, body, f) for body, f in wanted))
    data = np.load(work / "ply.npz")
    for i, (body, f) in enumerate(wanted):
        same(data[f"points{i}"], body.positions[f], f"{body.name}, frame {f}")
        if body.display == "triangles":
            assert data[f"cells{i}"] == body.cells[f], f"{body.name}: {data[f'cells{i}']} faces"
    return f"{len(wanted)} files of bodies"


def numpy_reads_npz(folder, truth, work):
    data = np.load(folder / "run.npz")
    assert data["frames/index"].tolist() == truth.frames, "other frames"
    assert [n for n in data["bodies/name"]] == [b.name for b in truth.bodies], "other bodies"
    for k, f in enumerate(truth.frames):
        for i, body in enumerate(truth.bodies):
            if f"display/{i}/positions" in data:
                x = data[f"display/{i}/positions"][0 if body.still else k]
            else:
                first, end = data[f"display/{i}/vertices/offset"][k:k + 2]
                x = data[f"display/{i}/vertices/position"][first:end]
            same(x, body.positions[f], f"{body.name}, frame {f}", 1e-5 if body.posed else 0)
        assert np.diff(data["contacts/offset"])[k] == truth.contacts[f], f"frame {f}: contacts"
    return f"{len(data.files)} arrays"


# ---- Blender -------------------------------------------------------------------------------------------------------

def blender(format, files, times, work):
    """Meshes that Blender has after importing: name -> time -> positions; and of volumes their grids."""
    job = {"format": format, "files": [str(f) for f in files], "times": times, "out": str(work / "blender.npz")}
    (work / "job.json").write_text(json.dumps(job))
    result = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python",
                             TOOLS / "check_exports_blender.py", "--", work / "job.json"], capture_output=True, text=True)
    assert result.returncode == 0, (result.stderr or result.stdout).strip().splitlines()[-1]
    return np.load(work / "blender.npz")


def blender_reads_obj(folder, truth, work):
    f = truth.frames[-1]
    data = blender("obj", [folder / f"frame_{f:05}.obj"], [0], work)
    bodies = [b for b in truth.bodies if b.display != "points"]  # it leaves points out
    for body in bodies:
        name = catalogue(folder)[body.name]["path"]
        same(found_in(data, f"{name}@0"), body.positions[f], body.name)
        if body.display == "triangles":
            faces = data[f"{name}#faces"]
            assert faces == body.cells[f], f"{body.name}: {faces} faces instead of {body.cells[f]}"
    return f"{len(bodies)} objects with their faces, frame {f} (it leaves points out)"


def blender_reads_ply(folder, truth, work):
    f = truth.frames[-1]
    data = blender("ply", [ply_of(folder, b, f) for b in truth.bodies], [0], work)
    for body in truth.bodies:
        same(found_in(data, f"{ply_of(folder, body, f).stem}@0"), body.positions[f], body.name)
    return f"{len(truth.bodies)} files, frame {f}"


def blender_reads_gltf(folder, truth, work):
    start = truth.times[truth.frames[0]]
    times = [truth.times[f] - start for f in truth.frames]
    data = blender("gltf", [folder / "run.glb"], times, work)
    for body in truth.bodies:
        for k, f in enumerate(truth.frames):
            if body.changing:  # an object for each frame; only the one of this frame has a size
                mine = [data[n] for n in data if n.startswith(f"{body.name}_") and n.endswith(f"@{k}")]
                shown = [x for x in mine if len(x) and np.ptp(x, axis=0).max() > 1e-6]
                assert len(shown) == 1, f"{body.name}, frame {f}: {len(shown)} surfaces at once"
                same_set(shown[0], body.positions[f], f"{body.name}, frame {f}")
                continue
            found = np.concatenate([found_in(data, f"{p}@{k}") for p in paths_of(folder, body)])
            same_set(found, body.positions[f], f"{body.name}, frame {f}")
    return f"{len(truth.bodies)} objects, moving as recorded at {len(truth.frames)} times"


def blender_reads_vdb(folder, truth, work):
    f = truth.frames[-1]
    data = blender("vdb", [folder / f"frame_{f:05}.vdb"], [0], work)
    found = set(data["grids"].tolist())
    assert found == {catalogue(folder)[b.name]["path"] for b in truth.bodies}, f"grids {sorted(found)}"
    return f"{len(found)} grids, frame {f}"


def vdb_print_reads_vdb(folder, truth, work):
    for f in truth.frames:
        result = subprocess.run(["vdb_print", "-l", folder / f"frame_{f:05}.vdb"], capture_output=True, text=True)
        assert result.returncode == 0, result.stderr
        names = [line.split(":", 1)[1].strip(" '") for line in result.stdout.splitlines()
                 if line.strip().startswith("Name:")] or result.stdout
        for body in truth.bodies:
            assert catalogue(folder)[body.name]["path"] in names, f"no grid of {body.name} in frame {f}"
    return f"{len(truth.bodies)} grids in each of {len(truth.frames)} files"


# ---- ParaView ------------------------------------------------------------------------------------------------------

def pvpython():
    return os.environ.get("BRIM_PVPYTHON") or shutil.which("pvpython")


def paraview(path, truth, work):
    """Reads a file at the recorded times: every block's points, by name and time."""
    job = {"file": str(path), "times": list(truth.times.values()), "out": str(work / "paraview.npz")}
    (work / "job.json").write_text(json.dumps(job))
    result = subprocess.run([*pvpython().split(), TOOLS / "check_exports_paraview.py", work / "job.json"],
                            capture_output=True, text=True)
    assert result.returncode == 0, (result.stderr or result.stdout).strip()[-400:]
    return np.load(work / "paraview.npz")


def paraview_reads(name, posed=True):
    """@param posed: bodies whose poses are recorded are there too, as they are not in a run's own run.xdmf"""
    def check(folder, truth, work):
        data = paraview(folder / name, truth, work)
        bodies = [b for b in truth.bodies if posed or not b.posed]
        for k, f in enumerate(truth.frames):
            for body in bodies:
                if len(body.positions[f]):
                    same(found_in(data, f"{body.name}@{k}"), body.positions[f], f"{body.name}, frame {f}")
        return f"{len(bodies)} bodies at {len(truth.frames)} times"
    return check


# ---- TinyUSDZ ------------------------------------------------------------------------------------------------------

def tinyusdz():
    """Folder of the npm package tinyusdz, which BRIM_TINYUSDZ names."""
    folder = os.environ.get("BRIM_TINYUSDZ")
    return folder if folder and shutil.which("node") and (pathlib.Path(folder) / "tinyusdz.wasm").exists() else None


def tinyusdz_reads_usda(folder, truth, work):
    out = work / "usd.json"
    result = subprocess.run(["node", TOOLS / "check_exports_usd.mjs", tinyusdz(), folder / "run.usda", out],
                            capture_output=True, text=True)
    assert result.returncode == 0, result.stderr.strip()[-400:]
    found, f = json.loads(out.read_text()), truth.frames[0]
    meshes = [b for b in truth.bodies if b.display == "triangles"]
    for body in meshes:
        parts = [found_in(found["meshes"], p.rsplit("/", 1)[1]) for p in paths_of(folder, body)]
        same(np.concatenate([p["points"] for p in parts]), body.positions[f], body.name)
        faces = sum(p["faces"] for p in parts)
        assert faces == body.cells[f], f"{body.name}: {faces} faces instead of {body.cells[f]}"
    missing = {p.rsplit("/", 1)[1] for b in truth.bodies for p in paths_of(folder, b)} - set(found["prims"])
    assert not missing, f"nothing of {', '.join(missing)}"
    return f"{len(found['prims'])} prims, {len(meshes)} meshes in place, frame {f} (it knows no later time)"


@dataclass
class Reader:
    format: str
    program: str
    available: Callable
    check: Callable  # (folder, truth, work) -> what was read; AssertionError when it is not what was recorded


def has_program(name):
    return lambda: shutil.which(name) is not None


READERS = [
    Reader("vtk", "VTK", lambda: has_module("vtk"), vtk_reads_vtk),
    Reader("vtk", "ParaView", pvpython, paraview_reads("run.pvd")),
    Reader("xdmf", "ParaView", pvpython, paraview_reads("run.xdmf")),
    Reader("run", "ParaView", pvpython, paraview_reads("run.xdmf", posed=False)),
    Reader("obj", "VTK", lambda: has_module("vtk"), vtk_reads_obj),
    Reader("obj", "Blender", has_program("blender"), blender_reads_obj),
    Reader("ply", "meshio", lambda: has_module("meshio"), meshio_reads_ply),
    Reader("ply", "Blender", has_program("blender"), blender_reads_ply),
    Reader("gltf", "Blender", has_program("blender"), blender_reads_gltf),
    Reader("vdb", "vdb_print", has_program("vdb_print"), vdb_print_reads_vdb),
    Reader("vdb", "Blender", has_program("blender"), blender_reads_vdb),
    Reader("usda", "TinyUSDZ", tinyusdz, tinyusdz_reads_usda),
    Reader("npz", "NumPy", lambda: True, numpy_reads_npz),
]
