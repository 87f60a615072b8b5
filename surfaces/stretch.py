"""From the world's coordinates to those of a surface's grid, for a roughness and an azimuth."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from surfaces.facet import Array

GOLDEN = (np.sqrt(5) - 1) / 2
"""Slope at which light crosses the grid. A ray along an axis would come back to the same line of
the surface with every period; one at the slope worst approximated by fractions comes back last."""


@dataclass(frozen=True)
class Stretch:
    """The linear map from lengths in standard deviations of height to cells of a grid."""

    matrix: Array
    """(3, 3); the z axis is its own."""

    @classmethod
    def of(cls, cells_x: float, cells_y: float, phi: float | None = None) -> "Stretch":
        """So many cells per unit length along x and y.

        The field is isotropic on its grid. So it may be turned there, such that light of azimuth
        `phi` crosses the grid at the slope `GOLDEN`; with None it is not turned.
        """
        matrix = np.diag([cells_x, cells_y, 1.0])
        if phi is not None:
            turn = np.arctan(GOLDEN) - np.arctan2(cells_y * np.sin(phi), cells_x * np.cos(phi))
            cos, sin = np.cos(turn), np.sin(turn)
            matrix = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]) @ matrix
        return cls(matrix)

    @cached_property
    def inverse(self) -> Array:
        """From the grid to the world, (3, 3)."""
        return np.linalg.inv(self.matrix)

    def to_grid(self, d: Array) -> Array:
        """Vectors (3, n) of the world on the grid."""
        return self.matrix @ d

    def to_world(self, d: Array) -> Array:
        """Vectors (3, n) of the grid in the world."""
        return self.inverse @ d

    def normals(self, slopes: Array) -> Array:
        """Upward normals (3, n) in the world, of z = 1, of planes of these slopes (2, n) a cell."""
        m = np.empty((3, slopes.shape[1]))
        np.matmul(-self.matrix[:2, :2].T, slopes, out=m[:2])
        m[2] = 1
        return m
