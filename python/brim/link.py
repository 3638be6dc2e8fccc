"""What holds bodies to each other: handles of attachments."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .body import Array

if TYPE_CHECKING:
    from .world import World


class Attachment:
    """An attachment or joint of a world, made by World.attach or World.joint."""

    def __init__(self, world: World, number: int) -> None:
        self._world = world
        self.number = number

    @property
    def name(self) -> str:
        return self._world._core.attachment_names()[self.number]

    @property
    def force(self) -> Array:
        """On its first body in the last sub-step [N], shape (3,); nan before the first step."""
        links = self._world._core.links()
        if self.number >= len(links):
            import numpy as np
            return np.full(3, np.nan)
        force: Array = links["force"][self.number].copy()
        return force

    @property
    def error(self) -> float:
        """Worst distance of its points from where it wants them [m]; nan before the first step."""
        links = self._world._core.links()
        return float(links["error"][self.number]) if self.number < len(links) else float("nan")

    @property
    def coordinate(self) -> float:
        """Of a joint that turns or slides, at the start of the last sub-step [rad or m]; nan before the first step."""
        links = self._world._core.links()
        return float(links["coordinate"][self.number]) if self.number < len(links) else float("nan")

    @property
    def effort(self) -> float:
        """Of a joint's drive, damping and limits, on its first body in the last sub-step [N m or N]."""
        links = self._world._core.links()
        return float(links["effort"][self.number]) if self.number < len(links) else float("nan")

    def set_drive(self, position: float = 0.0, velocity: float = 0.0) -> None:
        """What the drive of a joint aims at from the next step on [rad or m, rad/s or m/s]. No part of a saved state.

        @raises InputError where it has no drive
        """
        self._world._core.set_drive(self.number, position, velocity)

    @property
    def broken(self) -> bool:
        """True once it broke or was taken off."""
        return self._world._core.detached(self.number)

    def detach(self) -> None:
        """Takes it off for good."""
        self._world._core.detach(self.number)

    def __repr__(self) -> str:
        return f'<Attachment "{self.name}"{": broken" if self.broken else ""}>'
