"""Queries of worlds: rays, nearest points, overlaps."""

from __future__ import annotations

import math
from typing import Any, Iterable, NamedTuple, Union

import numpy as np

from . import _core
from .body import Array, Body, _matrix, _vector

Bodies = Union[Body, str, Iterable[Union[Body, str]]]


class Hit(NamedTuple):
    """A point of a body's surface that a query found."""

    body: Body
    part: int
    """Within the body: the link's solid of an articulated body, else 0."""
    point: Array
    """[m], shape (3,)"""
    normal: Array
    """Of the surface, outward, shape (3,)."""
    distance: float
    """[m] along the ray; to the surface of World.closest_point, negative inside."""


class Queries:
    """What a World answers about its matter as it is now. Nothing is kept between two calls. docs/cpp.md says what a hit
    means for each kind of body.

    only, ignore: bodies, by handle or name, one or several; the others, or these, are not seen.
    """

    _core: _core.Session

    def _handle(self, number: int) -> Body:
        raise NotImplementedError

    def _number_of(self, body: Body | str) -> int:
        raise NotImplementedError

    def raycast(self, origin: Any, direction: Any, max_distance: float = math.inf, *, only: Bodies | None = None,
                ignore: Bodies = ()) -> Hit | None:
        """The first surface that a ray meets; a body in which it begins is met at distance 0. direction: of any length but 0.
        @raises InputError"""
        return self._hit(self._core.raycast(_vector(origin, "origin"), _vector(direction, "direction"), float(max_distance),
                                            self._seen(only, ignore)))

    def closest_point(self, point: Any, max_distance: float = math.inf, *, only: Bodies | None = None,
                      ignore: Bodies = ()) -> Hit | None:
        """The nearest point of any surface; within bodies, of the one in which the point lies deepest. @raises InputError"""
        return self._hit(self._core.closest_point(_vector(point, "point"), float(max_distance), self._seen(only, ignore)))

    def overlap_ball(self, center: Any, radius: float, *, only: Bodies | None = None, ignore: Bodies = ()) -> list[Body]:
        """Bodies with matter in a ball [m]; radius 0: at a point. @raises InputError"""
        return [self._handle(b) for b in self._core.overlap_ball(_vector(center, "center"), float(radius),
                                                                 self._seen(only, ignore))]

    def overlap_box(self, center: Any, size: Any, rotation: Any = None, *, only: Bodies | None = None,
                    ignore: Bodies = ()) -> list[Body]:
        """Bodies with matter in a box. size: full extents [m], shape (3,). rotation: a quaternion (w, x, y, z) or a matrix
        (3, 3). @raises InputError"""
        turn = np.eye(3) if rotation is None else _matrix(rotation)
        return [self._handle(b) for b in self._core.overlap_box(_vector(center, "center"), turn.ravel().tolist(),
                                                                _vector(size, "size"), self._seen(only, ignore))]

    def _hit(self, found: tuple[int, int, Array, Array, float] | None) -> Hit | None:
        return None if found is None else Hit(self._handle(found[0]), *found[1:])

    def _seen(self, only: Bodies | None, ignore: Bodies) -> list[bool] | None:
        """One flag a body; None: all."""
        left_out = self._numbers(ignore)
        if only is None and not left_out:
            return None
        seen = set(range(self._core.body_count)) if only is None else self._numbers(only)
        return [b in seen and b not in left_out for b in range(self._core.body_count)]

    def _numbers(self, bodies: Bodies) -> set[int]:
        if isinstance(bodies, (Body, str)):
            bodies = (bodies,)
        return {self._number_of(body) for body in bodies}
