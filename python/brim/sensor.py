"""Sensors of worlds and of recorded runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _core
from .body import Array

if TYPE_CHECKING:
    from .world import World


class ContactEvent(NamedTuple):
    """A contact of two bodies that began or ended, as a sensor of the kind "contact" saw it."""

    sensor: str
    began: bool
    """Else it ended."""
    time: float
    """Start of the first, or end of the last sub-step with contact [s]."""
    body: str
    """On the sensor's side."""
    other: str
    duration: float
    """Of a contact that ended [s]."""
    impulse: Array
    """On `body`, of a contact that ended [N s], shape (3,)."""
    peak: float
    """Largest sum of normal forces of a sub-step, of a contact that ended [N]."""


class Sensor:
    """A sensor of a world, made by World.sensor. Its readings are those of the last step; before it, of the state."""

    def __init__(self, world: World, number: int) -> None:
        self._world = world
        self.number = number

    @property
    def name(self) -> str:
        return self._world._core.sensor_names()[self.number]

    @property
    def kind(self) -> str:
        return self._world._core.sensor_kind(self.number)

    @property
    def units(self) -> dict[str, str]:
        """Names of its readings, with their units."""
        return dict(self._world._core.sensor_channels(self.number))

    @property
    def values(self) -> Array:
        """All readings, in the order of units."""
        return self._world._core.sensor_values(self.number)

    def read(self) -> dict[str, float]:
        """All readings by name."""
        return {name: float(x) for name, x in zip(self.units, self.values)}

    def __getitem__(self, channel: str) -> Any:
        """One reading ("force_z"), or three as an array of shape (3,) ("force"). @raises KeyError"""
        return _pick(channel, list(self.units), self.values)

    @property
    def map(self) -> Array | None:
        """Pressure [Pa], mean of the last step, shape (rows, columns); None of other kinds."""
        return self._world._core.sensor_map(self.number)

    def on_event(self, function: Callable[[ContactEvent], Any]) -> Callable[[ContactEvent], Any]:
        """Decorator: called after each step with every contact that began or ended in it, in order of time. What it raises
        reaches the caller of step; the step has been taken then."""
        name = self.name

        def watch(world: World) -> None:
            for event in world.events:
                if event.sensor == name:
                    function(event)

        self._world.each_step(watch)
        return function

    def __repr__(self) -> str:
        return f'<{self.kind} sensor "{self.name}">'


class RunSensor:
    """A sensor of a recorded run: arrays over all frames."""

    def __init__(self, core: _core.SensorRecord, number: int, name: str, kind: str, channels: list[str], units: list[str],
                 cells: tuple[int, int], size: tuple[float, float], every_step: bool) -> None:
        self._core = core
        self._number = number
        self.name = name
        self.kind = kind
        self.units = dict(zip(channels, units))
        """Names of its readings, with their units."""
        self.size = size
        """Width and height of its map [m]."""
        self.every_step = every_step
        """Whether readings of every step were recorded."""
        self._cells = cells

    @property
    def values(self) -> NDArray[np.float64]:
        """All readings, shape (frames, readings)."""
        return self._core.values(self._number)

    def __getitem__(self, channel: str) -> NDArray[np.float64]:
        """One reading over all frames, shape (frames,) ("force_z"), or three, shape (frames, 3) ("force").
        @raises KeyError"""
        picked: NDArray[np.float64] = _pick(channel, list(self.units), self.values)
        return picked

    @property
    def steps(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Of every step: times [s], shape (steps,), and readings, shape (steps, readings). @raises InputError where they
        were not recorded"""
        rows = self._core.steps(self._number)
        return rows[:, 0], rows[:, 1:]

    def map(self, frame: int) -> NDArray[np.float32]:
        """Pressure [Pa], mean of a frame, shape (rows, columns). @raises InputError for other kinds"""
        return self._core.map(self._number, frame + len(self.values) if frame < 0 else frame)

    def __repr__(self) -> str:
        return f'<recorded {self.kind} sensor "{self.name}">'


def _pick(channel: str, names: list[str], values: NDArray[np.float64]) -> Any:
    if channel in names:
        picked = values[..., names.index(channel)]
        return float(picked) if picked.ndim == 0 else picked
    axes = [f"{channel}_{axis}" for axis in "xyz"]
    if all(axis in names for axis in axes):
        return values[..., [names.index(axis) for axis in axes]]
    raise KeyError(f'"{channel}"; there are {", ".join(names)}')
