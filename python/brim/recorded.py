"""Recorded runs as arrays."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .sensor import ContactEvent, RunSensor


class RunBody:
    """A body of a recorded run."""

    def __init__(self, run: Run, number: int, name: str, kind: str) -> None:
        self._core = run._core
        self._number = number
        self.name = name
        self.kind = kind

    @property
    def mass(self) -> float:
        """[kg]"""
        return self._core.mass(self._number)

    @property
    def positions(self) -> NDArray[np.float32]:
        """Vertices shown in all frames [m], shape (frames, n, 3). @raises InputError for surfaces that change; they have
        positions_at and triangles_at"""
        return self._core.positions_over(self._number, 0, self._core.frames)

    def positions_at(self, frame: int) -> NDArray[np.float32]:
        """Vertices shown in one frame [m], shape (n, 3)."""
        return self._core.positions(self._number, _from_start(frame, self._core.frames))

    def triangles_at(self, frame: int) -> NDArray[np.int32]:
        """Triangles of one frame, shape (m, 3)."""
        return self._core.triangles(self._number, _from_start(frame, self._core.frames))

    @property
    def triangles(self) -> NDArray[np.int32]:
        """Triangles, shape (m, 3)."""
        return self.triangles_at(0)

    @property
    def center(self) -> NDArray[np.float64]:
        """Mean of the vertices shown, all frames [m], shape (frames, 3)."""
        return self._core.samples_over(self._number, "center")

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Of the centre of mass, all frames [m/s], shape (frames, 3)."""
        return self._core.samples_over(self._number, "velocity")

    @property
    def force(self) -> NDArray[np.float64]:
        """Sum of contact forces on the body in the last sub-step of all frames [N], shape (frames, 3)."""
        return self._core.samples_over(self._number, "force")

    @property
    def impulse(self) -> NDArray[np.float64]:
        """Impulse of the contacts on the body over all frames, sub-steps included [N s], shape (frames, 3)."""
        return self._core.samples_over(self._number, "impulse")

    def q(self, frame: int) -> NDArray[np.float64]:
        """Coordinates in one frame, shape (nq,)."""
        first, count, _, _ = self._core.slices(self._number)
        return self._core.state(_from_start(frame, self._core.frames)).q[first:first + count]

    def v(self, frame: int) -> NDArray[np.float64]:
        """Velocities in one frame, shape (nv,)."""
        _, _, first, count = self._core.slices(self._number)
        return self._core.state(_from_start(frame, self._core.frames)).v[first:first + count]

    def __repr__(self) -> str:
        return f'<recorded {self.kind} "{self.name}">'


class Run:
    """A recorded run, finished or growing: arrays of what is in run.h5. Frame 0 is the start; -1 the last."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """path: of the run's folder, or of a run.h5. @raises InputError"""
        self._core = _core.RunReader(os.fspath(path))
        self.bodies = [RunBody(self, number, name, kind)
                       for number, (name, kind) in enumerate(self._core.body_names())]

    @property
    def path(self) -> str:
        return self._core.path

    @property
    def name(self) -> str:
        """Of the scene."""
        return self._core.scene_name

    @property
    def times(self) -> NDArray[np.float64]:
        """[s], shape (frames,)"""
        return self._core.times()

    @property
    def frame_time(self) -> float:
        """[s]"""
        return self._core.frame_time

    def __len__(self) -> int:
        """Frames, the first included."""
        return self._core.frames

    def __getitem__(self, name: str) -> RunBody:
        for body in self.bodies:
            if body.name == name:
                return body
        raise KeyError(name)

    def state(self, frame: int) -> _core.State:
        """For World.restore on a world of the same scene: goes on from there bit for bit."""
        return self._core.state(_from_start(frame, len(self)))

    def contacts(self, frame: int) -> NDArray[Any]:
        """As World.contacts."""
        return self._core.contacts(_from_start(frame, len(self)))

    def pairs(self, frame: int) -> NDArray[Any]:
        """As World.pairs."""
        return self._core.pairs(_from_start(frame, len(self)))

    def links(self, frame: int) -> NDArray[Any]:
        """Attachments and joints in the order of link_names, an array with named fields: force [N] (3,), error [m],
        coordinate [rad or m], effort [N m or N], broken."""
        return self._core.links(_from_start(frame, len(self)))

    @property
    def link_names(self) -> list[str]:
        return self._core.link_names()

    @property
    def sensors(self) -> list[RunSensor]:
        """What the sensors of the scene have read."""
        record = _core.SensorRecord(self._core)
        return [RunSensor(record, number, *facts) for number, facts in enumerate(record.sensors())]

    def sensor(self, name: str) -> RunSensor:
        """The sensor of that name. @raises KeyError"""
        for sensor in self.sensors:
            if sensor.name == name:
                return sensor
        raise KeyError(name)

    @property
    def events(self) -> list[ContactEvent]:
        """Contacts that began or ended, in order of time."""
        record = _core.SensorRecord(self._core)
        names = [facts[0] for facts in record.sensors()]
        return [ContactEvent(names[sensor], began, time, self.bodies[a].name, self.bodies[b].name, duration, impulse, peak)
                for sensor, began, time, a, b, duration, impulse, peak in record.events()]

    def report(self, frame: int) -> _core.StepReport:
        return self._core.report(_from_start(frame, len(self)))

    def series(self, name: str) -> NDArray[np.float64]:
        """A number of the reports over all frames ("worst_overlap", "kinetic_energy", ...: StepReport.fields), shape
        (frames,). @raises InputError for other names"""
        return self._core.series(name)

    def __repr__(self) -> str:
        return f'<Run "{self.name}": {len(self)} frames, {len(self.bodies)} bodies>'


def _from_start(frame: int, frames: int) -> int:
    return frame + frames if frame < 0 else frame
