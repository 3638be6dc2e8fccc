"""Worlds."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._core import InputError
from .articulated import Articulated
from .body import Array, Body, Force, _vector
from .link import Attachment
from .own_body import OwnBody
from .query import Queries
from .running import Running, StepError
from .sensor import ContactEvent, Sensor
from .scene_file import scene_text, take_arrays, write_arrays
from .view import View, view

_SCENE_KEYS = ("name", "description", "duration", "frames", "steps_per_frame", "materials", "pairs", "groups", "expect")


def _name(body: Body | str) -> str:
    return body if isinstance(body, str) else body.name


def _names(bodies: Body | str | list[Body | str]) -> str | list[str]:
    return [_name(body) for body in bodies] if isinstance(bodies, (list, tuple)) else _name(bodies)


def _air(function: Callable[[float, Array], Any]) -> Callable[[float, Array], Array]:
    """The same with its value broadcast to the shape of the places, and checked."""
    def air(t: float, x: Array) -> Array:
        try:
            velocity = np.broadcast_to(np.asarray(function(t, x), dtype=np.float64), x.shape)
        except (ValueError, TypeError) as error:
            name = getattr(function, "__name__", "field")
            raise ValueError(f"{name}: its value cannot be broadcast to shape {x.shape}: {error}") from None
        if not np.isfinite(velocity).all():
            raise ValueError(f"{getattr(function, '__name__', 'field')}: gave a velocity that is not finite")
        return np.ascontiguousarray(velocity)
    return air


class World(Queries):
    """Bodies, their state, and the step that moves them.

    Keywords are those of "world" in a scene file (time_step [s], voxel_size [m], gravity, stiffness [Pa], response, ...), and
    of the scene itself: name, materials, pairs, groups, steps_per_frame, frames or duration.
    """

    def __init__(self, **keys: Any) -> None:
        scene: dict[str, Any] = {"brim": 1, "name": keys.pop("name", "world")}
        for key in _SCENE_KEYS:
            if key in keys:
                scene[key] = keys.pop(key)
        if "frames" not in scene and "duration" not in scene:
            step = keys.get("time_step")
            # A file has up to 1e7 frames, and a world without an end any step.
            scene["duration"] = min(60.0, 1e6 * step) if isinstance(step, float) and step > 0.0 else 60.0
        scene["world"] = keys
        self._start(_core.Session(scene, os.getcwd()))

    @classmethod
    def _of(cls, core: _core.Session) -> World:
        world = cls.__new__(cls)
        world._start(core)
        return world

    def _start(self, core: _core.Session) -> None:
        self._core = core
        self._forces: list[tuple[Body, Any, Force]] = []
        self._asking = False
        self._watchers: list[Callable[[World], Any]] = []
        self._recorded: str | None = None
        self._view: View | None = None

    # ---- bodies ------------------------------------------------------------------------------------------------------

    def add(self, kind: str | OwnBody | type[OwnBody], **keys: Any) -> Any:
        """Adds a body and gives its handle; with the key "repeat", adds all copies and gives a list of handles.

        kind: one of a scene file ("rigid", "cloth", ...), whose keys, defaults and messages hold, or an OwnBody.
        Without a name the body is called by its kind and a number.

        Meshes and volumes may be arrays: vertices (n, 3) [m] with triangles (m, 3) in place of "mesh", with tetrahedra
        (m, 4) in place of "tet_mesh"; intensities (nx, ny, nz) with spacing (3,) [m] in place of "file". Surfaces and
        intensities are kept in single precision; vertices at equal positions become one.

        @raises InputError for what a scene file could not say either; nothing is added then
        """
        if isinstance(kind, OwnBody):
            return self._add_own(kind, **keys)
        if isinstance(kind, type) and issubclass(kind, OwnBody):
            raise InputError(f"add: {kind.__name__} is a class; add a body of it, {kind.__name__}(surface=...)")
        if not isinstance(kind, str):
            raise InputError(f"add: {kind!r} is not allowed; must be the name of a kind, or an OwnBody")
        name = keys.pop("name", None) or self._free_name(kind)
        keys = take_arrays(self._core, name, keys)
        self._need_no_step()
        numbers = self._core.add({"kind": kind, "name": name, **keys})
        bodies = [self._handle(number) for number in numbers]
        return bodies if "repeat" in keys else bodies[0]

    def _handle(self, number: int) -> Body:
        return (Articulated if self._core.kind(number) == "articulated" else Body)(self, number)

    def _number_of(self, body: Body | str) -> int:
        if isinstance(body, str):
            return self[body].number
        if body.world is not self:
            raise InputError(f"'{body.name}' is a body of another world")
        return body.number

    def _add_own(self, author: OwnBody, name: str | None = None, **keys: Any) -> Body:
        if keys:
            raise InputError(f"add: {', '.join(keys)}: not with a body of your own; its place and motion are q0 and v0, and the "
                             f"rest are arguments of {type(author).__name__}(...)")
        if not hasattr(author, "surface"):
            raise InputError(f"add: {type(author).__name__}.__init__ must call super().__init__(surface, ...)")
        self._need_no_step()
        name = name or author.name or self._free_name(type(author).__name__.lower())
        entry = take_arrays(self._core, name, {"shape": author.surface})
        entry.update(kind="rigid", name=name, density=author.density, voxel_size=author.voxel_size)
        if author.material is not None:
            entry["material"] = author.material
        if author.response is not None:
            entry["response"] = author.response
        number = self._core.add_own(entry, author, author.q0, author.v0, author.mass_spacing, author.stiffness_damping)
        return Body(self, number)

    def _free_name(self, kind: str) -> str:
        names = {self._core.name(number) for number in range(self._core.body_count)}
        number = 1
        while f"{kind}_{number}" in names:
            number += 1
        return f"{kind}_{number}"

    @property
    def bodies(self) -> list[Body]:
        """Handles of all bodies that are there; of those that were removed none."""
        return [self._handle(number) for number in range(self._core.body_count) if not self._core.removed(number)]

    def __getitem__(self, name: str) -> Body:
        """The body of that name. @raises KeyError"""
        for body in self.bodies:
            if body.name == name:
                return body
        raise KeyError(name)

    def __len__(self) -> int:
        return len(self.bodies)

    def __iter__(self) -> Iterator[Body]:
        return iter(self.bodies)

    # ---- wiring ------------------------------------------------------------------------------------------------------

    def attach(self, body: Body | str, to: Body | str | None = None, **keys: Any) -> Attachment:
        """Holds a point or a region of a body to another body, or to space where `to` is None, as they are now.

        keys: of an entry of "attachments" in a scene file: point or region, to_point, stiffness [N/m] (0: rigid), damping
        [N s/m], length [m], pulls_only, break_force [N], touch, keyframes, part, to_part, name.

        Attached before the first step, it is in saved scenes and recorded runs as it was made; later, a run that was
        recorded cannot be taken up again. Restoring a state from before takes it away.

        @raises InputError for what a scene file could not say either; nothing is added then
        """
        return self._wire("attachments", "attachment", body, to, keys)

    def joint(self, body: Body | str, to: Body | str | None = None, **keys: Any) -> Attachment:
        """Joins a body to another body, or to space where `to` is None, as they are now.

        keys: of an entry of "joints" in a scene file: kind ("fixed", "revolute", "prismatic", "ball"), position [m], axis, span
        [m], lower, upper, limit_stiffness, damping, drive, break_force [N], touch, part, to_part, name.

        @raises InputError for what a scene file could not say either; nothing is added then
        """
        return self._wire("joints", "joint", body, to, keys)

    def _wire(self, section: str, stem: str, body: Body | str, to: Body | str | None, keys: dict[str, Any]) -> Attachment:
        entry = {"name": keys.pop("name", None) or f"{stem}_{len(self._core.attachment_names()) + 1}",
                 "body": _name(body), **keys}
        if to is not None:
            entry["to"] = _name(to)
        return Attachment(self, self._core.wire(section, entry))

    @property
    def attachments(self) -> list[Attachment]:
        return [Attachment(self, number) for number in range(len(self._core.attachment_names()))]

    def sensor(self, kind: str, body: Body | str | list[Body | str] | None = None, **keys: Any) -> Sensor:
        """Adds a sensor, of the world as it is now.

        kind: "force", "contact", "pressure", "motion", "strain", "distance", "level" or "link". body: handle, name, stem of
        copies, pattern, group or a list of these; none for "link". keys: of an entry of "sensors" in a scene file: ``with_``
        (the other side of contacts), region, follows, about [m], least_force [N], gap [s], grid, point [m], part, to,
        to_point [m], link, sample ("frame" or "step"), name.

        @raises InputError for what a scene file could not say either; nothing is added then
        """
        entry = {"kind": kind, "name": keys.pop("name", None) or f"{kind}_{len(self._core.sensor_names()) + 1}", **keys}
        if "with_" in entry:
            entry["with"] = _names(entry.pop("with_"))
        if "to" in entry:
            entry["to"] = _name(entry["to"])
        if body is not None:
            entry["body"] = _names(body)
        return Sensor(self, self._core.wire("sensors", entry))

    @property
    def sensors(self) -> list[Sensor]:
        return [Sensor(self, number) for number in range(len(self._core.sensor_names()))]

    @property
    def events(self) -> list[ContactEvent]:
        """Contacts that began or ended in the last step, as the world's sensors of that kind saw them."""
        names = self._core.sensor_names()
        return [ContactEvent(names[sensor], began, time, self._core.name(a), self._core.name(b), duration, impulse, peak)
                for sensor, began, time, a, b, duration, impulse, peak in self._core.sensor_events()]

    def apply_force(self, *bodies: Body | str, **keys: Any) -> str:
        """Lets something act on bodies from outside, from now on; on all that can move where none is named. Restoring a state from
        before takes it away.

        bodies: handles, names, stems of copies or patterns with * and ?. keys: of an entry of "forces" in a scene file: force
        [N], torque [N m], acceleration [m/s^2], gravity_scale, damping [1/s], point, region, wind, attractor, scale, name.

        The field of a wind may be a function of yours, ``wind={"field": f}``: f(t, x) -> velocity of the air [m/s] at the places
        x [m], shape (n, 3), or what broadcasts to it. It is called once a sub-step and body, with the middles of all triangles,
        and is not in saved scenes.

        @return its name, for remove_force
        @raises InputError for what a scene file could not say either; nothing is added then
        """
        name = keys.pop("name", None) or self._free_force_name()
        field = None
        if callable(keys.get("wind", {}).get("field")):
            keys["wind"] = dict(keys["wind"])
            field = _air(keys["wind"].pop("field"))
        self._core.wire("forces", {"name": name, "bodies": [_name(body) for body in bodies], **keys}, field)
        return str(name)

    def remove_force(self, name: str) -> None:
        """Ends what apply_force began. Restoring a state from before brings it back. @raises InputError when there is none of
        that name"""
        self._core.remove_force(name)

    def _free_force_name(self) -> str:
        names = {entry["name"] for entry in self._core.head().get("forces", [])}
        number = len(names) + 1
        while f"force_{number}" in names:
            number += 1
        return f"force_{number}"

    def set_touch(self, a: Body | str, b: Body | str, touch: bool = False, **keys: Any) -> None:
        """Says whether bodies touch, over all that was said before: as an entry of "filters" in a scene file.

        a, b: handles, names, stems of copies, patterns with * and ?, or groups. keys: ``region`` and ``to_region``, a part of a and
        of b alone, where the matter is now.
        """
        self._core.wire("filters", {"between": [_name(a), _name(b)], "touch": touch, **keys})

    def set_gravity(self, gravity: Any) -> None:
        """From the next step on [m/s^2], shape (3,). It is part of a saved state, but not of a saved scene."""
        self._core.set_gravity(_vector(gravity, "gravity"))

    # ---- editing -----------------------------------------------------------------------------------------------------

    def remove(self, body: Body | str) -> None:
        """Takes a body out of the world. Its handle stays: ``removed`` is true, q and v are as they were last. The handles
        of others stay as they are, and its name is not given again. What holds to it is detached.

        Restoring an earlier state brings it back. @raises InputError when it was removed already
        """
        self._core.remove(self._number_of(body))

    def apply_impulse(self, body: Body | str, impulse: Any, point: Any) -> Array:
        """Changes a body's velocities at once by an impulse [N s] at its matter that is at a point [m] now, both of shape (3,):
        rigid bodies and links take any point, others where they have matter near it. Momentum and angular momentum change
        by the impulse and its moment, where nothing of the body is fixed.

        @return where it acted [m], shape (3,)  @raises InputError for bodies that are fixed, frozen, or have no points (grid fluids)
        """
        at = self._core.apply_impulse(self._number_of(body), _vector(impulse, "impulse"), _vector(point, "point"))
        return np.array(at)

    def set_material(self, name: str, **keys: Any) -> None:
        """Changes a material for all bodies that have it: friction, restitution, rolling_resistance [m], response ("penalty", "constraint",
        "inherit"), and name. @raises InputError; KeyError when no body has it"""
        having = [body for body in self.bodies if body.material["name"] == name]
        if not having:
            raise KeyError(name)
        for body in having:
            body.set_material(**keys)

    def set_pair(self, a: str, b: str, **keys: Any) -> None:
        """Replaces what a pair of materials has: friction, stiffness [Pa], restitution, rolling_resistance [m], response; what is left out follows
        from the two. As an entry of "pairs" in a scene file. @raises InputError"""
        for key in ("friction", "stiffness", "restitution", "rolling_resistance"):
            if key in keys and not float(keys[key]) >= 0.0:
                raise InputError(f"{key}: {keys[key]!r} is not allowed; must be a number from 0")
        self._core.set_pair_material(a, b, keys)

    def set_stiffness(self, stiffness: float) -> None:
        """Contact stiffness of all pairs without one of their own [Pa]. @raises InputError"""
        self._core.set_stiffness(float(stiffness))

    def pull(self, to: Any) -> None:
        """Where the place that was grabbed (``Body.grab``) is pulled from the next step on [m], shape (3,).
        @raises InputError when nothing is grabbed"""
        self._core.pull(_vector(to, "to"))

    def release(self) -> None:
        """Lets go of what is grabbed, if anything is."""
        self._core.release()

    @property
    def grabbed(self) -> Body | None:
        """The body that is grabbed."""
        number = self._core.grabbed()
        return None if number < 0 else self._handle(number)

    # ---- stepping ----------------------------------------------------------------------------------------------------

    def step(self) -> _core.StepReport:
        """Advances by time_step. Other Python threads run meanwhile.

        @raises StepError when the solve fails; whatever a force or a body written in Python raises, the world then being
        as it was before the step
        """
        return self._step(False)

    def _need_no_step(self) -> None:
        if self._asking:
            raise RuntimeError("the world is in the middle of a step: a force is being asked")

    def _step(self, joined: bool) -> _core.StepReport:
        self._need_no_step()
        self._core.step(joined, self._asked() if self._forces else {})
        report = self._core.report()
        if not report.ok:
            raise StepError(report)
        for watch in list(self._watchers):
            watch(self)
        return report

    def each_step(self, function: Callable[[World], Any]) -> Callable[[World], Any]:
        """Decorator: a sensor or controller, called as function(world) after each step. It may read everything, and set q
        and v of bodies. What it raises reaches the caller of step; the step has been taken then."""
        self._watchers.append(function)
        return function

    def _asked(self) -> dict[int, Array]:
        """The forces of the coming step, by number of body."""
        time = self._core.time
        total: dict[int, Array] = {}
        self._asking = True
        try:
            for body, ask, function in list(self._forces):
                force = ask(time, function)
                total[body.number] = total[body.number] + force if body.number in total else force
        finally:
            self._asking = False
        return total

    def run(self, frames: int | None = None, record: str | os.PathLike[str] | None = None, *,
            force: bool = False) -> Running:
        """Steps frame by frame: ``for frame in world.run(frames=120): ...``; ``world.run(...).all()`` runs to the end.

        frames: how many; those of the scene unless given. record: folder for a run that brim.Run, `brim view` and
        `brim export` open. force: replace an old run there.
        """
        return Running(self, self._core.frames if frames is None else frames, record, force)

    @property
    def time(self) -> float:
        """[s]"""
        return self._core.time

    @property
    def time_step(self) -> float:
        """[s]"""
        return self._core.time_step

    @property
    def report(self) -> _core.StepReport:
        """Of the last step, or of the last frame of a run."""
        return self._core.report()

    # ---- state -------------------------------------------------------------------------------------------------------

    def save(self) -> _core.State:
        """All that changes, for restore: a copy, which can be pickled."""
        return self._core.state()

    def restore(self, state: _core.State) -> None:
        """Goes back to a saved state, bit for bit: coordinates, edits, targets of drives, and which attachments and forces exist.
        What was attached or applied since is gone, and what existed then is back.

        A pickled state means attachments and forces by name, and one of a recorded run leaves them as they are. Forces that are
        functions (Body.force) are no part of a state, nor are keys of add.

        @raises InputError when bodies were added since, or the world has no attachment or force of a name
        """
        self._need_no_step()
        self._core.set_state(state)

    @property
    def hash(self) -> int:
        """Of the whole state: equal runs have equal hashes at every step."""
        return self._core.hash

    # ---- contact -----------------------------------------------------------------------------------------------------

    @property
    def contacts(self) -> NDArray[Any]:
        """Contacts of the last sub-step, an array with named fields, shape (n,): a copy.

        position [m] (3,); force (normal) and friction [N] (3,), on body_a; overlap [voxels]; part_a, part_b, body_a,
        body_b. ``world.contacts["force"]`` has shape (n, 3).
        """
        return self._core.contacts()

    @property
    def pairs(self) -> NDArray[Any]:
        """Totals of touching pairs of parts in the last sub-step, an array with named fields, shape (n,): a copy.

        force (normal and friction) and friction [N] (3,), on body_a; center of pressure [m] (3,); worst_overlap [voxels];
        contacts; part_a, part_b, body_a, body_b.
        """
        return self._core.pairs()

    def force(self, a: Body, b: Body) -> Array:
        """Contact force of b on a in the last sub-step, friction included [N], shape (3,)."""
        pairs = self._core.pairs()
        number_a, number_b = self._number_of(a), self._number_of(b)
        on_a = (pairs["body_a"] == number_a) & (pairs["body_b"] == number_b)
        on_b = (pairs["body_a"] == number_b) & (pairs["body_b"] == number_a)
        total: Array = pairs["force"][on_a].sum(0) - pairs["force"][on_b].sum(0)
        return total

    @property
    def tiles(self) -> tuple[NDArray[np.int64], Array]:
        """Tiles of 8 x 8 x 8 nodes on which two parts met: keys (n, 3) and steps h [m] (n,). Node (i, j, k) of tile
        (x, y, z) is at h (8 x + i, 8 y + j, 8 z + k)."""
        return self._core.tiles()

    def density(self, part: int, h: float, tiles: Any) -> Array:
        """Fraction filled by a part at the nodes of tiles of step h [m]: shape (n, 8, 8, 8), axes x, y, z. tiles: (n, 3)."""
        return self._core.density(part, h, np.ascontiguousarray(tiles, dtype=np.int64).reshape(-1, 3))

    # ---- files and views ---------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        return str(self._core.head()["name"])

    def save_scene(self, path: str | os.PathLike[str], frames: int | None = None) -> None:
        """Writes the world, as it was built, as a scene file; arrays go to files in "arrays" beside it. Forces
        written in Python are not in it; targets of drives that were set are, as edits at 0. @raises InputError when there is a body written in Python: nothing is written then"""
        for entry in self._core.entries():
            if entry["kind"] == "python":
                raise _core.InputError(f'"{entry["name"]}" is written in Python and cannot be saved in a scene file')
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(scene_text(self._core, self.name, frames or max(1, self._core.frames)))
        write_arrays(self._core, path.parent)

    def show(self, record: str | os.PathLike[str] | None = None, *, height: int = 520) -> View:
        """Shows the last recorded run, or the world as it is now, in the viewer's page; in a notebook as a frame."""
        folder = str(record) if record is not None else self._recorded
        if folder is None:
            import tempfile
            folder = os.path.join(tempfile.mkdtemp(prefix="brim_"), self.name)
            Running(self, 0, folder, False).all()
        if self._view is not None:
            self._view.close()
        self._view = view(folder, height=height)
        return self._view

    def __repr__(self) -> str:
        return f'<World "{self.name}": {len(self)} bodies, {self.time:.6g} s>'


def load(path: str | os.PathLike[str], *, set: Mapping[str, Any] | None = None, seed: int | None = None) -> World:
    """The world of a scene file.

    set: values of the scene's "parameters" by name, or of any key by JSON pointer, as --set of the program:
    {"h": 0.02, "/world/time_step": 0.01}. seed: another seed for all that is drawn by chance, as --seed.

    @raises InputError: file, line, pointer, what is wrong and what is allowed
    """
    return World._of(_core.Session.load(os.fspath(path), dict(set or {}), seed))
