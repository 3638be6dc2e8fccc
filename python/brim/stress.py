"""Stress of elastic solids."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stress:
    """Deformation and stress of a solid's material, element by element: copies. Finite elements and deformable image
    volumes have tetrahedra; a meshless body has samples, and no tetrahedra."""

    place: Array
    """[m], shape (p, 3): nodes of the tetrahedra, or the n samples."""
    tetrahedra: NDArray[np.int32]
    """Indices into place, shape (n, 4); (0, 4) of samples."""
    volume: Array
    """[m³] at rest, shape (n,)."""
    filled: Array
    """Share of the volume that is matter, shape (n,): below 1 at the outside of image volumes."""
    deformation: Array
    """Deformation gradient F, shape (n, 3, 3)."""
    stress: Array
    """[Pa] Cauchy's stress, elastic, tension positive, mean over the whole volume; shape (n, 3, 3)."""

    @property
    def von_mises(self) -> Array:
        """[Pa] equivalent stress, shape (n,)."""
        deviator: Array = self.stress - np.trace(self.stress, axis1=1, axis2=2)[:, None, None] / 3 * np.eye(3)
        equivalent: Array = np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2)))
        return equivalent

    @property
    def strain(self) -> Array:
        """Green-Lagrange strain ½ (FᵀF − 1), shape (n, 3, 3)."""
        return 0.5 * (np.swapaxes(self.deformation, 1, 2) @ self.deformation - np.eye(3))

    @property
    def centers(self) -> Array:
        """[m] of the elements, shape (n, 3)."""
        centers: Array = self.place[self.tetrahedra].mean(axis=1) if len(self.tetrahedra) else self.place
        return centers
