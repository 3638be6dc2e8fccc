"""An opened run as Blender needs it: places of rigid pieces and positions of everything else, at any moment.

Frames are read one by one when they are asked for; a moment between two frames is mixed from both. Nothing of Blender here.
"""

import os

import numpy as np

from .run_file import RunFile

PALETTE = ("#4f83b5", "#e2a03f", "#b8455f", "#43a88c", "#e8c9a0", "#6b4f8f", "#8cc7dd", "#7b5a3a")
STILL = "#b4babd"  # both as in viewer/src/scene/palette.ts


def run_path(path):
    """The run.h5 that a path means: the file itself, or the one in a run's folder."""
    path = os.path.abspath(path)
    return os.path.join(path, "run.h5") if os.path.isdir(path) else path


class Source:
    """run.h5, opened. `bodies` and `frames` as in RunFile; `piece_body`, `piece_mesh` say of each rigid piece whose it is."""

    def __init__(self, path):
        self.path = run_path(path)
        self.run = RunFile(self.path)
        self.bodies, self.frames = self.run.bodies, self.run.frames
        if self.frames == 0:
            raise OSError("the run has no frames yet")
        file = self.run.file
        self.name = str(file.attrs["scene"]) or "brim run"
        self.frame_time = float(file.attrs["frame_time"])
        has_poses = self.run.version > 1
        self.piece_body = file["poses/body"][:] if has_poses else np.zeros(0, int)
        self.piece_mesh = file["poses/mesh"][:] if has_poses else np.zeros(0, int)
        self.still = np.array([self.run.still(b) for b in self.bodies])

    def close(self):
        self.run.file.close()

    def pieces(self, body):
        """Numbers of a body's rigid pieces; none where it deforms or changes."""
        return np.flatnonzero(self.piece_body == body.index)

    def mesh(self, number):
        """Vertices (n, 3) and triangles (m, 3) of a mesh that pieces share."""
        file = self.run.file
        first, end = file["meshes/first_vertex"][number:number + 2]
        begin, stop = file["meshes/first_triangle"][number:number + 2]
        return file["meshes/vertices"][first:end], file["meshes/triangles"][begin:stop]

    def around(self, moment):
        """The frame before a moment [frames], the one after, and the weight of the latter; moments outside are the ends."""
        moment = min(max(moment, 0.0), self.frames - 1.0)
        before = int(moment)
        return before, min(before + 1, self.frames - 1), moment - before

    def poses(self, frame):
        """Rotations (pieces, 3, 3) and translations (pieces, 3) of a frame."""
        file = self.run.file
        return file["poses/rotation"][frame].reshape(-1, 3, 3), file["poses/translation"][frame]

    def positions(self, body, moment):
        """Display positions of a body (n, 3) float32; of a surface that changes those of the frame before the moment."""
        before, after, weight = self.around(moment)
        x = self.run.positions(body, before)
        if weight == 0 or body.changing:
            return x
        return ((1 - weight) * x + weight * self.run.positions(body, after)).astype(np.float32)

    def triangles(self, body, moment):
        return self.run.triangles(body, self.around(moment)[0])

    def colours(self):
        """A colour #rrggbb for each body, those of the viewer: grey for what never moves, the palette in turn for the rest."""
        moving = iter(range(len(self.bodies)))
        return [STILL if still else PALETTE[next(moving) % len(PALETTE)] for still in self.still]

    def boxes(self, frame):
        """Lower and upper corner of every body in a frame, (bodies, 2, 3); NaN of a body that shows nothing."""
        boxes = np.full((len(self.bodies), 2, 3), np.nan)
        for body in self.bodies:
            x = self.run.positions(body, frame)
            x = x[np.isfinite(x).all(axis=1)]
            if len(x):
                boxes[body.index] = x.min(axis=0), x.max(axis=0)
        return boxes
