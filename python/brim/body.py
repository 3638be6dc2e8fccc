"""Handles of bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable

import numpy as np
from numpy.typing import NDArray

from . import _core
from .stress import Stress

if TYPE_CHECKING:
    from .world import World

Array = NDArray[np.float64]
Force = Callable[[float, Array, Array], Any]


def _numbers(value: Any, name: str) -> Array:
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise _core.InputError(f"{name}: {value!r} is not allowed; must be numbers") from None


def _vector(value: Any, name: str) -> list[float]:
    vector = _numbers(value, name)
    if vector.shape != (3,):
        raise _core.InputError(f"{name}: shape {vector.shape} is not allowed; must be (3,)")
    numbers: list[float] = vector.tolist()
    return numbers


def _matrix(rotation: Any) -> Array:
    r = _numbers(rotation, "rotation")
    if r.shape == (3, 3):
        return r
    if r.shape != (4,):
        raise _core.InputError(f"rotation: shape {r.shape} is not allowed; must be a quaternion (w, x, y, z) or a matrix (3, 3)")
    if not np.linalg.norm(r) > 0 or not np.isfinite(r).all():
        raise _core.InputError(f"rotation: the quaternion {r.tolist()} is not allowed; must have a length and finite numbers")
    w, x, y, z = r / np.linalg.norm(r)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


class Body:
    """A body of a world; made by World.add and World.__getitem__."""

    def __init__(self, world: World, number: int) -> None:
        self._world = world
        self._core = world._core
        self._number = number

    @property
    def world(self) -> World:
        return self._world

    @property
    def number(self) -> int:
        """Its place among the world's bodies, from 0; body_a and body_b of contacts are such numbers."""
        return self._number

    @property
    def name(self) -> str:
        return self._core.name(self._number)

    @property
    def kind(self) -> str:
        """The word for its kind in scenes: "rigid", "cloth", ..."""
        return self._core.kind(self._number)

    @property
    def mass(self) -> float:
        """[kg]; infinite when it is fixed or animated."""
        return self._core.mass(self._number)

    # ---- state -------------------------------------------------------------------------------------------------------

    @property
    def q(self) -> Array:
        """Generalised coordinates, shape (nq,): a view that stays valid and follows every step.

        Rigid bodies: centre of mass [m] and quaternion w x y z; bodies of nodes: their positions [m]. Writing to it moves
        the body at the next step, or when anything that depends on it is asked for. Of a removed body it cannot be written.
        """
        return self._core.q(self._number)

    @q.setter
    def q(self, value: Any) -> None:
        self.q[:] = value

    @property
    def v(self) -> Array:
        """Generalised velocities, shape (nv,): a view that stays valid and follows every step; writing sets them.

        Rigid bodies: velocity of the centre of mass [m/s] and spin [rad/s] in the world's axes; bodies of nodes: those of
        the nodes.
        """
        return self._core.v(self._number)

    @v.setter
    def v(self, value: Any) -> None:
        self.v[:] = value

    @property
    def nodal(self) -> bool:
        """True where coordinates are the positions of nodes: finite elements, cloth, springs, rods, grains, particles."""
        return self._core.nodal(self._number)

    @property
    def positions(self) -> Array:
        """[m], shape (n, 3). Of bodies of nodes: the nodes, a view of q. Of others: the vertices shown, a copy."""
        if self.nodal:
            return self.q.reshape(-1, 3)
        return self._core.positions(self._number).astype(np.float64)

    @property
    def velocities(self) -> Array:
        """[m/s], shape (n, 3), of the nodes of bodies of nodes: a view of v. @raises TypeError for others"""
        if not self.nodal:
            raise TypeError(f"{self!r} has no nodes; its velocities are v")
        return self.v.reshape(len(self.positions), -1)[:, :3]

    @property
    def surface(self) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Vertices [m] (n, 3) and triangles (m, 3) as the viewer shows them: copies. Lines and points have no triangles."""
        return self._core.positions(self._number), self._core.triangles(self._number)

    @property
    def stress(self) -> Stress:
        """Deformation and stress of its elements, now. @raises TypeError for what is no elastic solid: finite elements,
        deformable image volumes and meshless bodies are"""
        arrays = self._core.stress(self._number)
        if arrays is None:
            raise TypeError(f"{self!r} has no elements of an elastic solid; its stress is not known")
        return Stress(*arrays)

    @property
    def asleep(self) -> bool:
        """True while the body is left out of steps because it rests (World(sleep=True)). Forces and writing wake it."""
        return self._core.asleep(self._number)

    # ---- editing -----------------------------------------------------------------------------------------------------

    @property
    def center(self) -> Array:
        """Centre of mass [m], shape (3,): of all links of an articulated body, those that are fixed to the world included, as in mass.
        Of obstacles the mean of the vertices shown."""
        return self._core.middle(self._number)

    def remove(self) -> None:
        """Takes the body out of the world: World.remove."""
        self._core.remove(self._number)

    @property
    def removed(self) -> bool:
        return self._core.removed(self._number)

    def grab(self, at: Any = None, *, stiffness: float = 0.0, damping: float = 0.0) -> None:
        """Takes hold of the body by a spring to a place in space, which ``World.pull`` moves and ``World.release`` ends;
        what was held before is let go. A hand is no part of saved states and records.

        at: [m], shape (3,), where its matter is now; its centre unless given. Of what gives way the matter within two voxels
        is held. stiffness [N/m], damping [N s/m]: 0 for 3 Hz with the body's mass, half damped.

        @raises InputError for what does not move, and grid fluids, which have no points to hold
        """
        place = self.center if at is None else _vector(at, "at")
        self._core.grab(self._number, place, float(stiffness), float(damping))

    def freeze(self) -> None:
        """Makes the body stay where it is, as an obstacle would, until thaw. @raises InputError where keyframes move it"""
        self._core.freeze(self._number, True)

    def thaw(self) -> None:
        """Lets a frozen body go again, at rest."""
        self._core.freeze(self._number, False)

    @property
    def frozen(self) -> bool:
        return self._core.frozen(self._number)

    def move(self, by: Any = (0.0, 0.0, 0.0), *, to: Any = None, rotation: Any = None, about: Any = None) -> None:
        """Sets the body elsewhere, with its shape and its motion, which turns along.

        by: [m], shape (3,). to: where its centre shall be [m], in place of by. rotation: a quaternion (w, x, y, z) or a matrix
        (3, 3), about the point `about` [m]; its centre unless given.

        @raises InputError for bodies that cannot be elsewhere, are attached, or are moved by keyframes
        """
        turn = np.eye(3) if rotation is None else _matrix(rotation)
        center = self.center
        pivot = center if about is None else np.array(_vector(about, "about"))
        turned = turn @ (center - pivot) + pivot
        shift = np.array(_vector(by, "by")) if to is None else np.array(_vector(to, "to")) - turned
        translation = shift if rotation is None else pivot - turn @ pivot + shift
        self._core.move(self._number, turn.ravel().tolist(), translation.tolist())

    def set_velocity(self, velocity: Any = (0.0, 0.0, 0.0), angular_velocity: Any = (0.0, 0.0, 0.0)) -> None:
        """Gives the body the motion of a rigid one: of its centre of mass [m/s], and about it [rad/s], both of shape (3,). An obstacle keeps
        it until it is given another, in place of its keyframes; its velocity is that of the origin of its frame.
        @raises InputError for bodies that are fixed, frozen, or cannot move as a whole"""
        self._core.set_velocity(self._number, _vector(velocity, "velocity"), _vector(angular_velocity, "angular_velocity"))

    def set_target(self, position: Any = None, rotation: Any = None, duration: float = 0.0) -> None:
        """Moves an obstacle to a place [m] and rotation of its frame within a time [s], 0: in the next step, and holds it there.
        It pushes and carries what it touches on the way. What is not given stays. rotation: a quaternion (w, x, y, z) or a
        matrix (3, 3); the shorter turn is taken. Replaces its keyframes. @raises InputError for bodies other than obstacles"""
        place = None if position is None else _vector(position, "position")
        turn = None if rotation is None else _matrix(rotation).ravel().tolist()
        self._core.set_target(self._number, place, turn, float(duration))

    @property
    def material(self) -> dict[str, Any]:
        """Of its first part: name, friction, restitution, rolling_resistance [m], response. Set it to such a dict, or to the name of one of the
        world's materials, and all parts have it; the response then stays the body's own."""
        return self._core.material(self._number)

    @material.setter
    def material(self, value: str | dict[str, Any]) -> None:
        keys = dict(self._core.named_material(value) if isinstance(value, str) else value)
        if isinstance(value, str):
            del keys["response"]
        self._core.set_material(self._number, keys)

    def set_material(self, **keys: Any) -> None:
        """Changes some of name, friction, restitution, rolling_resistance and response ("penalty", "constraint", "inherit"). @raises InputError"""
        self._core.set_material(self._number, keys)

    # ---- measures ----------------------------------------------------------------------------------------------------

    @property
    def kinetic_energy(self) -> float:
        """[J]"""
        return self._core.kinetic_energy(self._number)

    @property
    def linear_momentum(self) -> Array:
        """[kg m/s], shape (3,)"""
        return self._core.linear_momentum(self._number)

    @property
    def angular_momentum(self) -> Array:
        """About the world's origin [kg m²/s], shape (3,)"""
        return self._core.angular_momentum(self._number)

    @property
    def contact_force(self) -> Array:
        """Sum of the contact forces on the body in the last sub-step, friction included [N], shape (3,)."""
        pairs = self._world.pairs
        on_a, on_b = pairs["body_a"] == self._number, pairs["body_b"] == self._number
        total: Array = pairs["force"][on_a].sum(0) - pairs["force"][on_b].sum(0)
        return total

    # ---- forces ------------------------------------------------------------------------------------------------------

    def force(self, function: Force) -> Force:
        """Decorator: a force, called once a step as function(t, x, v) and broadcast to shape (n, 3), [N].

        t: time [s]; x, v: positions [m] and velocities [m/s], shape (n, 3). Bodies of nodes: a row a node. Rigid bodies: one
        row, the centre of mass. The force acts over the whole step. Other kinds take generalized_force.
        """
        if not self._core.takes_forces(self._number):
            raise TypeError(f"{self!r} takes no forces")
        if not self.nodal and self._core.frame_center(self._number) is None:
            raise TypeError(f"{self!r} has neither nodes nor a rigid frame; use generalized_force")
        self._world._forces.append((self, self._nodal_force if self.nodal else self._frame_force, function))
        return function

    def torque(self, function: Force) -> Force:
        """Decorator for rigid bodies: a torque about the centre of mass, function(t, q, v) -> (3,), [N m]."""
        if self.nodal or self._core.frame_center(self._number) is None or not self._core.takes_forces(self._number):
            raise TypeError(f"{self!r} is not rigid; use {'force or ' if self.nodal else ''}generalized_force")
        self._world._forces.append((self, self._frame_torque, function))
        return function

    def generalized_force(self, function: Force) -> Force:
        """Decorator: function(t, q, v) -> (nv,), the force along each of the body's velocities. Obstacles and grid fluids
        take none."""
        if not self._core.takes_forces(self._number):
            raise TypeError(f"{self!r} takes no forces")
        self._world._forces.append((self, self._own_force, function))
        return function

    def remove_force(self, function: Force) -> None:
        """Takes a force away again. @raises ValueError when the body has no such force"""
        for entry in self._world._forces:
            if entry[0]._number == self._number and entry[2] is function:
                self._world._forces.remove(entry)
                return
        raise ValueError(f"{self!r} has no such force")

    def _given(self, function: Force, value: Any, shape: tuple[int, ...]) -> Array:
        if value is None:
            name = getattr(function, "__name__", "force")
            raise ValueError(f"{name}: gave None; must give numbers that can be broadcast to shape {shape}")
        try:
            force = np.broadcast_to(np.asarray(value, dtype=np.float64), shape)
        except (ValueError, TypeError) as error:
            name = getattr(function, "__name__", "force")
            raise ValueError(f"{name}: its value cannot be broadcast to shape {shape}: {error}") from None
        return force

    def _nodal_force(self, t: float, function: Force) -> Array:
        x, v = self.positions.copy(), self.velocities.copy()
        force = np.zeros((len(x), self.v.size // len(x)))
        force[:, :3] = self._given(function, function(t, x, v), x.shape)
        return force.ravel()

    def _frame_force(self, t: float, function: Force) -> Array:
        v = self.v.copy()
        x = np.asarray(self._core.frame_center(self._number)).reshape(1, 3)
        total = np.zeros(v.shape)
        total[:3] = self._given(function, function(t, x, v[:3].reshape(1, 3)), (1, 3))[0]
        return total

    def _frame_torque(self, t: float, function: Force) -> Array:
        v = self.v.copy()
        total = np.zeros(v.shape)
        total[3:] = self._given(function, function(t, self.q.copy(), v), (3,))
        return total

    def _own_force(self, t: float, function: Force) -> Array:
        v = self.v.copy()
        return self._given(function, function(t, self.q.copy(), v), v.shape)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Body) and other._core is self._core and other._number == self._number

    def __hash__(self) -> int:
        return hash((id(self._core), self._number))

    def __repr__(self) -> str:
        return f'<{self.kind} "{self.name}">'
