"""Handles of articulated bodies, their joints and links."""

from __future__ import annotations

from typing import Any, Tuple

import numpy as np

from ._core import InputError, nearest_word
from .body import Array, Body, _matrix, _vector


# Name, kind, first coordinate and their number, the same of velocities, lower, upper, number of the drive or -1, stiffness, damping.
_Row = Tuple[str, str, int, int, int, int, float, float, int, float, float]


class Articulated(Body):
    """An articulated body of a world: a tree of links that joints connect."""

    _table: list[_Row] | None = None
    _links: list[str] | None = None

    def _joints(self) -> list[_Row]:
        if self._table is None:
            self._table = self._core.joint_table(self._number)
        return self._table

    @property
    def joints(self) -> list[str]:
        """Names of the joints that move, in the order of q and v: those of the file or, where a joint has no name, of the link
        that it carries."""
        return [row[0] for row in self._joints()]

    @property
    def driven(self) -> list[str]:
        """Names of the joints with a drive that can be aimed, in the order of joints. A drive of a ball joint holds it at rest."""
        return [row[0] for row in self._joints() if row[8] >= 0]

    @property
    def links(self) -> list[str]:
        """Names of all links."""
        if self._links is None:
            self._links = self._core.link_names(self._number)
        return list(self._links)

    def joint(self, joint: str | int) -> Joint:
        """A joint that moves, by name or by its place in joints. @raises InputError"""
        return Joint(self, self._number_in(self.joints, joint, "a joint that moves"))

    def link(self, link: str | int) -> Link:
        """A link, by name or by its place in links. @raises InputError"""
        return Link(self, self._number_in(self.links, link, "a link"))

    def set_drive(self, joint: str | int, position: float | None = None, velocity: float = 0.0) -> None:
        """Targets of the drive of a joint from the next step on [rad or m, rad/s or m/s], which hold until set again; keyframes
        of the drive end. Part of a saved state.

        position may be left out where the drive has no stiffness.

        @raises InputError for what is no joint, has no drive, or for which the drive has no stiffness or damping
        """
        number = self._number_in(self.joints, joint, "a joint that moves")
        name, kind, *_, drive, stiffness, damping = self._joints()[number]

        def refuse(why: str) -> InputError:
            return InputError(f'set_drive: joint "{name}" of "{self.name}" {why}')

        if drive < 0:
            if kind == "ball" and (stiffness > 0 or damping > 0):
                raise refuse("is a ball joint; its drive holds it at rest and cannot be aimed")
            driven = ", ".join(f'"{other}"' for other in self.driven) or "none"
            raise refuse(f'has no drive; joints with one: {driven}')
        if position is None:
            if stiffness > 0:
                raise refuse("needs a position, for its drive has a stiffness")
            position = 0.0
        elif position != 0 and not stiffness > 0:
            raise refuse(f"cannot be at position {position}; its drive has no stiffness")
        if velocity != 0 and not damping > 0:
            raise refuse(f"cannot have the velocity {velocity}; its drive has no damping")
        self._core.aim_drive(self._number, drive, float(position), float(velocity))

    def set_drives(self, positions: Any, velocities: Any = None) -> None:
        """Targets of all drives, as set_drive: shape (n,) each, in the order of driven; velocities are 0 unless given. Of the two
        a drive follows those for which it has a stiffness or a damping. @raises InputError"""
        self._core.aim_drives(self._number, positions, velocities)

    @property
    def efforts(self) -> Array:
        """What the drives apply along their joints [N m or N], shape (n,), in the order of driven: the law of the drive, with its
        force limit, at the present coordinates and rates."""
        return self._core.drive_efforts(self._number)

    def jacobian(self, link: str | int, point: Any = (0.0, 0.0, 0.0)) -> Array:
        """J, shape (6, nv): J @ v are velocity [m/s] and angular velocity [rad/s] of a point of a link, in the world's axes.

        point: [m], shape (3,), in the frame of the link."""
        return self.link(link).jacobian(point)

    def _number_in(self, names: list[str], given: str | int, what: str) -> int:
        if isinstance(given, str):
            if given in names:
                return names.index(given)
            near = nearest_word(given, names)
            known = f'did you mean "{near}"?' if near else "there are " + ", ".join(f'"{name}"' for name in names)
            raise InputError(f'"{given}" is not {what} of "{self.name}"; {known}')
        if isinstance(given, (int, np.integer)) and 0 <= given < len(names):
            return int(given)
        raise InputError(f'{given!r} is not {what} of "{self.name}"; must be a name, or a number from 0 to {len(names) - 1}')


class Joint:
    """A joint of an articulated body that moves, made by Articulated.joint."""

    def __init__(self, body: Articulated, number: int) -> None:
        self._body = body
        self._number = number
        self._row = body._joints()[number]

    @property
    def name(self) -> str:
        return str(self._row[0])

    @property
    def kind(self) -> str:
        """ "revolute", "prismatic", "ball" or "free"."""
        return str(self._row[1])

    @property
    def q(self) -> Array:
        """Its coordinates, a view of q of the body: an angle [rad] or displacement [m]; of ball and free joints quaternions."""
        return self._body.q[self._row[2]:self._row[2] + self._row[3]]

    @property
    def v(self) -> Array:
        """Its velocities, a view of v of the body."""
        return self._body.v[self._row[4]:self._row[4] + self._row[5]]

    @property
    def coordinate(self) -> float:
        """Of a joint that turns or slides [rad or m]. @raises TypeError for others"""
        return float(self._one(self.q)[0])

    @property
    def rate(self) -> float:
        """Of a joint that turns or slides [rad/s or m/s]. @raises TypeError for others"""
        return float(self._one(self.v)[0])

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest coordinate [rad or m], infinite where there is none."""
        return float(self._row[6]), float(self._row[7])

    @property
    def effort(self) -> float:
        """What its drive applies [N m or N], as Articulated.efforts; 0 without a drive."""
        return float(self._body.efforts[self._row[8]]) if self._row[8] >= 0 else 0.0

    def set_drive(self, position: float | None = None, velocity: float = 0.0) -> None:
        """As Articulated.set_drive."""
        self._body.set_drive(self._number, position, velocity)

    def _one(self, numbers: Array) -> Array:
        if self._row[5] != 1:
            raise TypeError(f'joint "{self.name}" is {self.kind}; its coordinates are q and v')
        return numbers

    def __repr__(self) -> str:
        return f'<Joint "{self.name}" of "{self._body.name}": {self.kind}>'


class Link:
    """A link of an articulated body, made by Articulated.link. All are of the present state, in the world's axes."""

    def __init__(self, body: Articulated, number: int) -> None:
        self._body = body
        self._number = number

    def _state(self) -> tuple[Array, ...]:
        return self._body._core.link_state(self._body.number, self._number)

    @property
    def name(self) -> str:
        return self._body.links[self._number]

    @property
    def position(self) -> Array:
        """Of its frame, which is that of its joint [m], shape (3,)."""
        return self._state()[0]

    @property
    def rotation(self) -> Array:
        """From its frame, a quaternion (w, x, y, z)."""
        return self._state()[1]

    @property
    def center(self) -> Array:
        """Centre of mass [m], shape (3,)."""
        return self._state()[2]

    @property
    def velocity(self) -> Array:
        """Of its position [m/s], shape (3,)."""
        return self._state()[3]

    @property
    def center_velocity(self) -> Array:
        """Of its centre of mass [m/s], shape (3,)."""
        return self._state()[4]

    @property
    def angular_velocity(self) -> Array:
        """[rad/s], shape (3,)."""
        return self._state()[5]

    def place(self, point: Any) -> Array:
        """Where a point of its frame is [m], shape (3,)."""
        position, rotation, *_ = self._state()
        place: Array = position + _matrix(rotation) @ np.array(_vector(point, "point"))
        return place

    def jacobian(self, point: Any = (0.0, 0.0, 0.0)) -> Array:
        """As Articulated.jacobian."""
        return self._body._core.link_jacobian(self._body.number, self._number, _vector(point, "point"))

    def __repr__(self) -> str:
        return f'<Link "{self.name}" of "{self._body.name}">'
