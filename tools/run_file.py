"""Reads the displays of a run.h5 of any version of the format (docs/formats.md). Needs h5py and NumPy."""

import os
from dataclasses import dataclass, field

os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")
import h5py  # noqa: E402
import numpy as np  # noqa: E402


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


@dataclass
class Body:
    """A body: its attributes by name, and its cells where they are the same in all frames."""
    index: int
    attrs: dict
    cells: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), int))

    @property
    def name(self):
        return text(self.attrs["name"])

    @property
    def kind(self):
        return text(self.attrs["kind"])

    @property
    def display(self):
        return text(self.attrs["display_kind"])

    @property
    def changing(self):
        return bool(self.attrs.get("changing", 0))


class RunFile:
    """run.h5, opened: `file` is the h5py.File, `bodies` the bodies in order."""

    def __init__(self, path):
        self.file = h5py.File(path, "r")
        self.version = int(self.file.attrs["version"])
        self.frames = len(self.file["frames/time"]) if self.version == 1 else int(self.file["frames/count"][0])
        self.bodies = self._bodies_1() if self.version == 1 else self._bodies_2()

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        self.file.close()

    def still(self, body):
        """True while the body shows the same in all frames."""
        if body.changing:
            return False
        if self.version == 1:
            return self.file[f"display/{body.index}/positions"].shape[0] <= 1
        return bool(self.file["bodies/still"][body.index])

    def positions(self, body, frame):
        """Display positions of a body in a frame, (vertices, 3) float32."""
        if body.changing:
            return self._rows(body, "vertices", "position", frame)
        if self.version == 1:
            shown = self.file[f"display/{body.index}/positions"]
            return shown[min(frame, len(shown) - 1)]
        first = int(body.attrs["first_position"])
        if first >= 0:
            return self.file["display/positions"][frame, first:first + int(body.attrs["vertices"])]
        placed = []
        for piece in np.flatnonzero(self.file["poses/body"][:] == body.index):
            mesh = int(self.file["poses/mesh"][piece])
            begin, end = self.file["meshes/first_vertex"][mesh:mesh + 2]
            rest = self.file["meshes/vertices"][begin:end]
            turn = self.file["poses/rotation"][frame, piece].reshape(3, 3)
            placed.append(rest @ turn.T + self.file["poses/translation"][frame, piece])
        return np.concatenate(placed).astype(np.float32) if placed else np.zeros((0, 3), np.float32)

    def triangles(self, body, frame):
        return self._rows(body, "triangles", "corner", frame) if body.changing else body.cells

    def _rows(self, body, group, column, frame):
        shown = self.file[f"display/{body.index}/{group}"]
        first, end = shown["offset"][frame:frame + 2]
        return shown[column][first:end]

    def _bodies_1(self):
        found = []
        for b in range(len(self.file["bodies"])):
            about = self.file[f"bodies/{b}"]
            body = Body(b, dict(about.attrs))
            if body.display in about:
                body.cells = about[body.display][:]
            found.append(body)
        return found

    def _bodies_2(self):
        table = {name: self.file[f"bodies/{name}"][:] for name in self.file["bodies"]}
        mesh_of = self.file["poses/mesh"][:]
        owner = self.file["poses/body"][:]
        starts = {kind: self.file[f"display/first_{kind}"][:] for kind in ("triangle", "line")}
        found = []
        for b in range(len(table["name"])):
            body = Body(b, {name: column[b] for name, column in table.items()})
            if body.display in ("triangles", "lines"):
                first, end = starts[body.display[:-1]][b:b + 2]
                body.cells = self.file[f"display/{body.display}"][first:end]
            shift, cells = 0, []
            for mesh in mesh_of[owner == b]:
                first, end = self.file["meshes/first_triangle"][mesh:mesh + 2]
                cells.append(self.file["meshes/triangles"][first:end] + shift)
                shift += int(np.diff(self.file["meshes/first_vertex"][mesh:mesh + 2])[0])
            if cells:
                body.cells = np.concatenate(cells)
            found.append(body)
        return found
