"""Light in any directions as light at nodes: Fourier modes of one azimuth, or a folded grid.

What nodes hold of light is what an interpolation between them takes of each: the sum of light
times a smooth function is then the sum over nodes, wherever light goes in between.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.solver.anisotropic import QuarterGrid
from msbsdf_cli.methods.solver.isotropic import distinct_elevations, parting, upward
from msbsdf_cli.methods.solver.nodes import SplitElevations, coordinate
from msbsdf_cli.methods.solver.slope_quadrature import Light
from surfaces.facet import Array


@dataclass(frozen=True)
class InterpolatedModes:
    """One roughness: modes of the azimuth from the light's own."""

    elevations: SplitElevations
    blocks: int
    half = True

    @cached_property
    def nodes(self) -> Array:
        """Upward directions (3, n)."""
        return upward(self.elevations.nodes)

    @property
    def weight(self) -> Array:
        """Solid angles over azimuths (n,)."""
        return self.elevations.nodes.weight

    def distinct(self, d: Array) -> tuple[Array, Array]:
        ends, which = distinct_elevations(d)
        return np.array([np.hypot(ends[0], ends[1]), 0 * ends[0], ends[2]]), which

    def parting(self, a: Array, b: Array) -> Array:
        return parting(a, b, self.blocks)

    def spread(self, light: Light) -> Array:
        """Light (blocks, 2 n) at the nodes: downward ones, then upward ones."""
        modes = _spread(self.elevations, light, _waves(_turns(light.w), self.blocks).real)
        return np.moveaxis(modes, -1, 0).reshape(self.blocks, -1)


@dataclass(frozen=True)
class InterpolatedGrid(QuarterGrid):
    """Two roughnesses: four parities on a quarter of the directions."""

    elevations: SplitElevations
    half = False

    def spread(self, light: Light) -> Array:
        """Light (blocks, 2 n) at the nodes: downward ones, then upward ones."""
        turns, q = self.azimuths.relax(_turns(light.w)), self.quarter
        even, odd = self._interpolants
        if self.blocks == 1:
            waves = _spread(self.elevations, light, _waves(turns * turns, q).real)
            return (waves @ even[0]).reshape(1, -1)
        waves = _spread(self.elevations, light, _waves(turns, 2 * q + 1).view(float))
        cosine, sine = waves[..., ::2], waves[..., 1::2]
        blocks = [
            cosine[..., : 2 * q : 2] @ even[0],
            cosine[..., 1::2] @ odd[0],
            sine[..., 1::2] @ odd[1],
            sine[..., 2::2] @ even[1],
        ]
        return np.stack(blocks).reshape(self.blocks, -1)

    @cached_property
    def _interpolants(self) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Factors (waves, quarter) of the trigonometric interpolant of each parity: of cos and
        sin of even multiples of the azimuth, then of odd ones (the discrete cosine and sine
        transforms II and IV)."""
        q, k = self.quarter, np.arange(self.quarter)[:, None]
        scale = np.full((q, 1), 2 / q)
        ends = scale.copy()
        # Of these waves the first, cos(0), or the last, +-1 at the nodes, is twice as large.
        ends[0] /= 2
        phi = self.azimuths.even
        even = ends * np.cos(2 * k * phi), ends[::-1] * np.sin(2 * (k + 1) * phi)
        odd = scale * np.cos((2 * k + 1) * phi), scale * np.sin((2 * k + 1) * phi)
        return even, odd


def _turns(w: Array) -> Array:
    """exp(i phi) of directions (3, n)."""
    sin = np.hypot(w[0], w[1])
    up = sin == 0
    turns: Array = np.where(up, 1, w[0] + 1j * w[1]) / np.where(up, 1, sin)
    return turns


def _waves(turns: Array, n: int) -> Array:
    """The powers (lanes, n) of complex numbers on the unit circle, from 0 to n - 1."""
    powers = np.ones((turns.size, n), complex)
    done, power = 1, turns[:, None]
    while done < n:
        part = powers[:, done : 2 * done]
        np.multiply(powers[:, : part.shape[1]], power, out=part)
        done, power = 2 * done, power * power
    return powers


def _spread(elevations: SplitElevations, light: Light, waves: Array) -> Array:
    """Light times waves (lanes, k), at the nodes' elevations (2, n, k), down and up."""
    w = light.w
    share = elevations.interpolation(coordinate(np.hypot(w[0], w[1]), np.abs(w[2])))
    share *= light.amount[:, None]
    sides = (np.flatnonzero(side) for side in (w[2] < 0, w[2] >= 0))
    return np.stack([share[lanes].T @ waves[lanes] for lanes in sides])
