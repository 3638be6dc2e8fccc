"""Bodies written in Python."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class OwnBody:
    """A body of a few coordinates whose author says where its matter is; arrays in, arrays out.

    Derive from it, set ``q0``, and give four methods (docs/bodies/your_own.md says what follows from them)::

        deform(q, X)          where the matter is that is at X at rest  (n,), (m, 3) -> (m, 3)  [m]
        inverse_deform(q, x)  the inverse                               (n,), (m, 3) -> (m, 3)  [m]
        distance(q, x)        signed, to the surface, negative inside   (n,), (m, 3) -> (m,)    [m]
        energy(q)             of the body's own forces                  (n,) -> number          [J]

    and, where there is a formula, in place of differences::

        jacobian(q, X)        derivative of deform by q                 (n,), (m, 3) -> (m, 3, n)
        force(q)              minus the derivative of energy by q       (n,) -> (n,)

    and, where the body moves by itself::

        update(t)             the time [s], for the others to use; called before them

    ``place`` and ``rest`` are the former names of ``deform`` and ``inverse_deform``, and go on working.

    Each is called on the thread that steps the world, once for all points of a part, and must change nothing (``update`` may set what the others read). What they
    raise ends the step, whose world then is as it was before, and reaches the caller of step.
    """

    q0: Any = ()
    """Coordinates at the start, any units, shape (n,)."""
    v0: Any = None
    """dq/dt at the start, shape (n,); None: at rest."""
    jacobian: Any = None
    force: Any = None
    update: Any = None

    def __init__(self, surface: dict[str, Any], *, name: str | None = None, density: float = 1000.0,
                 material: str | None = None, response: str | None = None, voxel_size: float = 0.0,
                 mass_spacing: float = 0.0, stiffness_damping: float = 0.0, q0: Any = None, v0: Any = None) -> None:
        """
        surface: a closed shape at rest (brim.sphere, brim.mesh, ...): its matter, for mass and display.
        density: [kg/m³]. voxel_size: [m], 0: an eighth of the smallest extent. mass_spacing: [m] between the pieces of
        matter whose motion is summed, 0: an eighth of the extent. stiffness_damping: [s]. q0, v0: instead of the class's.
        """
        self.surface = surface
        self.name = name
        self.density = density
        self.material = material
        self.response = response
        self.voxel_size = voxel_size
        self.mass_spacing = mass_spacing
        self.stiffness_damping = stiffness_damping
        if q0 is not None:
            self.q0 = q0
        if v0 is not None:
            self.v0 = v0

    def deform(self, q: Array, X: Array) -> Any:
        return self.place(q, X)

    def inverse_deform(self, q: Array, x: Array) -> Any:
        return self.rest(q, x)

    def place(self, q: Array, X: Array) -> Any:
        raise NotImplementedError(f"{type(self).__name__} must say where its matter is: deform(q, X)")

    def rest(self, q: Array, x: Array) -> Any:
        raise NotImplementedError(f"{type(self).__name__} must say which matter is at x: inverse_deform(q, x)")

    def distance(self, q: Array, x: Array) -> Any:
        raise NotImplementedError(f"{type(self).__name__} must say how far its surface is: distance(q, x)")

    def energy(self, q: Array) -> Any:
        return 0.0
