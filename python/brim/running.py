"""Frames of a world that runs, recorded or not."""

from __future__ import annotations

import operator
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _core
from .scene_file import scene_text, write_arrays

if TYPE_CHECKING:
    from .world import World


class StepError(RuntimeError):
    """A step whose solve failed; the state is that before the failed sub-step. ``report`` says what happened."""

    def __init__(self, report: _core.StepReport) -> None:
        super().__init__("; ".join(w.message for w in report.warnings) or "the step failed")
        self.report = report


class Frame(NamedTuple):
    """One frame of a run."""

    number: int
    """From 1."""
    time: float
    """[s]"""
    report: _core.StepReport


class Running:
    """An iterator over the frames of a run; made by World.run. A run that is left early is closed with what it has."""

    def __init__(self, world: World, frames: int, record: str | os.PathLike[str] | None, force: bool) -> None:
        try:
            frames = operator.index(frames)
        except TypeError:
            raise TypeError(f"frames: {frames!r} is not allowed; must be a whole number from 0") from None
        if frames < 0:
            raise ValueError(f"frames: {frames} is not allowed; must be a whole number from 0")
        self._world = world
        self._frames = frames
        self._number = 0
        self._recorder: _core.Recorder | None = None
        self._done = False
        self.findings: list[dict[str, Any]] = []
        """What became of the scene's expectations, after the last frame of a recorded run."""
        if record is not None:
            self._open(os.fspath(record), force)

    def _open(self, folder: str, force: bool) -> None:
        core = self._world._core
        folder = os.path.abspath(folder)
        text, origin = core.text, core.file
        if not text:  # built here: the run's own folder is where relative paths start from
            text, origin = scene_text(core, self._world.name, max(1, self._frames)), os.path.join(folder, "scene.json")
        self._recorder = _core.Recorder(core, folder, self._world.name, self._frames, core.steps_per_frame, text, origin,
                                        force)
        if not core.text:
            write_arrays(core, Path(folder))
        self._world._recorded = folder

    def __len__(self) -> int:
        return self._frames

    def __iter__(self) -> Running:
        return self

    def __next__(self) -> Frame:
        if self._number >= self._frames:
            self._finish("completed")
            raise StopIteration
        core = self._world._core
        try:
            for step in range(core.steps_per_frame):
                report = self._world._step(step > 0)
        except StepError:
            self._record(core.steps_per_frame)
            self._finish("failed")
            raise
        except BaseException:
            self._finish("interrupted")
            raise
        self._number += 1
        self._record(core.steps_per_frame)
        if self._number == self._frames:
            self._finish("completed")
        return Frame(self._number, core.time, report)

    def _record(self, steps: int) -> None:
        if self._recorder is not None and not self._done:
            self._recorder.add(self._world._core, steps)

    def _finish(self, end: str) -> None:
        if self._recorder is not None and not self._done:
            self.findings = self._recorder.finish(self._world._core, end)
        self._done = True

    def all(self) -> Frame | None:
        """Runs to the end. @return the last frame"""
        last = None
        for last in self:
            pass
        return last

    def close(self) -> None:
        """Ends the run; what is recorded of it stays."""
        self._finish("interrupted" if self._number < self._frames else "completed")
        self._frames = self._number

    def __enter__(self) -> Running:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __del__(self) -> None:
        try:
            if self._recorder is not None and not self._done:
                self.close()
        except Exception:
            pass
