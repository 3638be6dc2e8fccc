"""Checks of bodies written by users."""

from __future__ import annotations

from ._core import InputError
from .body import Body
from .own_body import OwnBody
from .world import World


def check(body: OwnBody | Body, *, seed: int = 1) -> None:
    """Holds the functions of a body of your own against each other: force against energy, jacobian against deform,
    inverse_deform against deform, distance against the surface (sign, place, slope), and the mass, whose every coordinate
    must have an effect of its own. At its start, and at random coordinates near it, which move matter by up to 2 % of its
    extent (docs/bodies/your_own.md).

    body: an OwnBody, which is tried in a world of its own, or the handle of one in a world, in Python or C++.

    @raises InputError with one line for each function that is wrong: where, the value, and what is allowed; whatever a
    function raises
    """
    if isinstance(body, OwnBody):
        world = World(materials={body.material: {}}) if getattr(body, "material", None) else World()
        handle: Body = world.add(body)
    else:
        handle = body
    found = handle._core.check_own(handle.number, seed)
    if found:
        raise InputError("\n".join(found))
