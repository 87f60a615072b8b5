"""Light in any directions as light at nodes: Fourier modes of one azimuth, or a folded grid.

What nodes hold of light is what an interpolation between them takes of each: the sum of light
times a smooth function is then the sum over nodes, wherever light goes in between.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.solver.anisotropic import QuarterGrid
from msbsdf_cli.methods.solver.isotropic import distinct_elevations, parting, upward
from msbsdf_cli.methods.solver.nodes import SplitElevations, coordinate, sparse_modes
from msbsdf_cli.methods.solver.slope_quadrature import Light
from surfaces.facet import Array

DENSE_WITH_EDGES = 32
"""As `nodes.DENSE`, where total reflection begins at some azimuths, which makes modes swing."""


@dataclass(frozen=True)
class InterpolatedModes:
    """One roughness: modes of the azimuth from the light's own."""

    elevations: SplitElevations
    modes: int
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
        return self._numbers[1].T @ parting(a, b, self.modes)

    @cached_property
    def _numbers(self) -> tuple[Array, Array]:
        return sparse_modes(self.modes, DENSE_WITH_EDGES)

    def spread(self, light: Light) -> Array:
        """Light (blocks, 2 n) at the nodes: downward ones, then upward ones."""
        numbers = self._numbers[0]
        out = np.empty((numbers.size, 2, self.elevations.n))
        for side, down in enumerate((True, False)):
            lanes = np.flatnonzero((light.w[2] < 0) == down)
            w, amount = light.w[:, lanes], light.amount[lanes]
            share = _shares(self.elevations, w, amount)
            out[:, side] = _cosines(_turns(w).real, numbers) @ share
        return out.reshape(numbers.size, -1)


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


def _cosines(cos: Array, numbers: Array) -> Array:
    """cos(m phi), (k, lanes), for cos(phi) (lanes,) and increasing m from 0 on, `numbers` (k,)."""
    waves = np.empty((numbers.size, cos.size))
    before, now, double = cos, np.ones_like(cos), 2 * cos
    row = 0
    for m in range(numbers[-1] + 1):
        if numbers[row] == m:
            waves[row] = now
            row += 1
        before, now = now, double * now - before
    return waves


def _shares(elevations: SplitElevations, w: Array, amount: Array) -> Array:
    """What of each direction's (3, lanes) amount falls to each elevation, (lanes, n)."""
    share = elevations.interpolation(coordinate(np.hypot(w[0], w[1]), np.abs(w[2])))
    share *= amount[:, None]
    return share


def _spread(elevations: SplitElevations, light: Light, waves: Array) -> Array:
    """Light times waves (lanes, k), at the nodes' elevations (2, n, k), down and up."""
    share = _shares(elevations, light.w, light.amount)
    sides = (np.flatnonzero(side) for side in (light.w[2] < 0, light.w[2] >= 0))
    return np.stack([share[lanes].T @ waves[lanes] for lanes in sides])
