"""Runs a scene and reads what experiments want of it."""
import json
import pathlib
import shutil
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from run_file import RunFile  # noqa: E402
from run_scenes import finish  # noqa: E402


class Run:
    """A run that has ended. Names are those of bodies; every time series has shape (frames, ...)."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.file = RunFile(self.folder / "run.h5")
        self.summary = json.loads((self.folder / "summary.json").read_text(encoding="utf-8"))
        self.frames = self.file.frames
        self.time = self.file.file["frames/time"][:self.frames]
        self._names = [b.name for b in self.file.bodies]

    def number(self, name):
        return self._names.index(name)

    def _motion(self, what, name):
        return self.file.file[f"motion/{what}"][:self.frames, self.number(name)]

    def center(self, name):
        """[m] mean of what is shown of it, (frames, 3)"""
        return self._motion("center", name)

    def velocity(self, name):
        """[m/s] of the centre of mass, (frames, 3)"""
        return self._motion("velocity", name)

    def force(self, name):
        """[N] contact force on it at each frame's end, (frames, 3)"""
        return self._motion("force", name)

    def tilt(self, name):
        """[degrees] of its own vertical, (frames)"""
        return self._motion("tilt_degrees", name)

    def lowest(self, name):
        return self._motion("lowest", name)

    def highest(self, name):
        return self._motion("highest", name)

    def series(self, name):
        return self.file.file[f"series/{name}"][:self.frames]

    def _body(self, name):
        return self.file.bodies[self.number(name)]

    def mass(self, name):
        return float(self._body(name).attrs["mass"])

    def v(self, name):
        """Generalised velocities, (frames, n)"""
        a = self._body(name).attrs
        first = int(a["v_offset"])
        return self.file.file["frames/v"][:self.frames, first:first + int(a["v_size"])]

    def q(self, name):
        """Generalised coordinates, (frames, n)"""
        a = self._body(name).attrs
        first = int(a["q_offset"])
        return self.file.file["frames/q"][:self.frames, first:first + int(a["q_size"])]

    def spin(self, name):
        """[rad/s] of a rigid body, (frames, 3)"""
        return self.v(name)[:, 3:6]

    def positions(self, name, frame):
        """[m] what is shown of it, (vertices, 3)"""
        return self.file.positions(self._body(name), frame).astype(float)

    def nodes(self, name):
        """[m], [m/s] nodes of a body whose coordinates are places, (frames, n, 3) each"""
        x = self.q(name).reshape(self.frames, -1, 3)
        return x, self.v(name).reshape(*x.shape[:2], -1)[:, :, :3]

    def at(self, time):
        """The frame nearest to a time."""
        return int(np.argmin(np.abs(self.time - time)))


def simulate(brim, scene, folder, limit):
    """Runs a scene in a fresh folder. @return (Run, processor seconds); raises RuntimeError with brim's own words."""
    folder = pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    path = folder.parent / (folder.name + ".json")
    scene = dict(scene)
    for name, text in scene.pop("files", {}).items():
        (path.parent / name).write_text(text, encoding="utf-8")
    path.write_text(json.dumps(scene), encoding="utf-8")
    command = [brim, "run", str(path), "-o", str(folder), "--force", "--quiet", "--threads", "1"]
    code, seconds, _, errors = finish(command, limit)
    if code is None:
        raise RuntimeError(f"did not end within {limit:.0f} s")
    if code:
        raise RuntimeError(errors.strip()[-300:])
    return Run(folder), seconds
