"""What holds bodies to each other: handles of attachments."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._core import InputError
from .body import Array

if TYPE_CHECKING:
    from .world import World


class Attachment:
    """An attachment or joint of a world, made by World.attach or World.joint."""

    def __init__(self, world: World, number: int) -> None:
        self._world = world
        self._id = world._core.attachment_ids()[number]
        self._name = world._core.attachment_names()[number]

    def _place(self) -> int:
        """Its place among the attachments that exist; -1 where the state that was restored has none of it."""
        ids = self._world._core.attachment_ids()
        return ids.index(self._id) if self._id in ids else -1

    @property
    def number(self) -> int:
        """Its place in World.attachments. @raises InputError where it does not exist in the present state"""
        place = self._place()
        if place < 0:
            raise InputError(f'attachment "{self._name}" is not there; the state that was restored is from before it was made')
        return place

    @property
    def name(self) -> str:
        return self._name

    def _reported(self, field: str) -> Any:
        links = self._world._core.links()
        place = self._place()
        return links[field][place] if 0 <= place < len(links) else None

    def _number_reported(self, field: str) -> float:
        value = self._reported(field)
        return float("nan") if value is None else float(value)

    @property
    def force(self) -> Array:
        """On its first body in the last sub-step [N], shape (3,); nan before the first step."""
        force = self._reported("force")
        return np.full(3, np.nan) if force is None else np.array(force, dtype=np.float64)

    @property
    def error(self) -> float:
        """Worst distance of its points from where it wants them [m]; nan before the first step."""
        return self._number_reported("error")

    @property
    def coordinate(self) -> float:
        """Of a joint that turns or slides, at the start of the last sub-step [rad or m]; nan before the first step."""
        return self._number_reported("coordinate")

    @property
    def effort(self) -> float:
        """Of a joint's drive, damping and limits, on its first body in the last sub-step [N m or N]."""
        return self._number_reported("effort")

    def set_drive(self, position: float = 0.0, velocity: float = 0.0) -> None:
        """What the drive of a joint aims at from the next step on [rad or m, rad/s or m/s], until set again; keyframes of
        the drive end. Part of a saved state.

        @raises InputError where it has no drive
        """
        self._world._core.set_drive(self.number, position, velocity)

    @property
    def broken(self) -> bool:
        """True once it broke or was taken off, and where it does not exist in the state that was restored."""
        place = self._place()
        return place < 0 or self._world._core.detached(place)

    def detach(self) -> None:
        """Takes it off: for good, but for states from before. Nothing where it does not exist."""
        place = self._place()
        if place >= 0:
            self._world._core.detach(place)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Attachment) and other._world is self._world and other._id == self._id

    def __hash__(self) -> int:
        return hash((id(self._world), self._id))

    def __repr__(self) -> str:
        return f'<Attachment "{self.name}"{": broken" if self.broken else ""}>'
