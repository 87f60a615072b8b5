"""Dielectric interfaces: light on two sides that see the same surface from either end.

Light inside is kept point-reflected, so that both sides are half spaces above the same Smith
surface; a transmission changes sides, and C1 becomes 1 - C1. Heights do not integrate out, so
one arriving direction is followed facet by facet: the density of light that leaves a facet, over
heights x sides x directions, one Fourier mode at a time ([HHdD16] Algorithm 1 with distributions
in place of samples).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.solver.heights import Heights
from msbsdf_cli.methods.solver.isotropic import CHUNK
from msbsdf_cli.methods.solver.nodes import Angles, Elevations, abscissa, azimuths
from msbsdf_cli.smith.kernel import dielectric_density
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Dielectric

AZIMUTHS = 160
"""Azimuths for the kernel itself, which has edges where reflection becomes total."""


@dataclass(frozen=True)
class Scattered:
    """Scattering from some directions to the nodes, weights included.

    Arrays are (modes, rows, 2 n): downward nodes, then upward ones.
    """

    reflected: Array
    transmitted: Array


@dataclass(frozen=True)
class Flights:
    """Light that leaves facets, as weights of sums over the nodes."""

    leaving: list[Array]
    """After the facets of order 1 to K, and summed over all later ones: (modes, sides, heights,
    2 n)."""
    unresolved: float
    """Energy not followed to its end."""


@dataclass(frozen=True)
class TwoSides:
    """The discretised interface: kernels of both sides, free paths of both hemispheres."""

    slopes: Slopes
    material: Dielectric
    elevations: Elevations
    heights: Heights
    modes: int

    @cached_property
    def sigma(self) -> Array:
        """Projected areas (2 n,) of the nodes' directions."""
        nodes = self.elevations.nodes
        z = np.concatenate([-nodes.cos, nodes.cos])
        sin = np.concatenate([nodes.sin, nodes.sin])
        return self.slopes.sigma(np.array([sin, 0 * sin, z]))

    @cached_property
    def weight(self) -> Array:
        """Solid angles over azimuths (2 n,)."""
        return np.tile(self.elevations.nodes.weight, 2)

    @cached_property
    def extinction(self) -> Array:
        """sigma / |cos| (2 n,) of the nodes' directions."""
        return self.sigma / np.tile(self.elevations.nodes.cos, 2)

    @cached_property
    def paths(self) -> Array:
        """Free paths (2 n, heights, heights)."""
        down, up = np.split(self.extinction, 2)
        return np.concatenate([self.heights.sink(down), self.heights.rise(up)])

    @cached_property
    def kernels(self) -> tuple[Scattered, Scattered]:
        """Distribution after a facet met from each node's direction, on either side."""
        nodes = self.elevations.nodes
        sin, z = np.tile(nodes.sin, 2), np.concatenate([-nodes.cos, nodes.cos])
        rows = (self.rows(sin, z, side) for side in (0, 1))
        first, second = (
            Scattered(*(_share(e, self.sigma[:, None]) for e in (r.reflected, r.transmitted)))
            for r in rows
        )
        return first, second

    def eta(self, side: int) -> float:
        """Index behind the facets over the index before them."""
        return self.material.ior if side == 0 else 1 / self.material.ior

    def rows(self, sin: Array, z: Array, side: int) -> Scattered:
        """Scattering from directions of sine and z (rows,), on one side, to the nodes."""
        step = max(CHUNK // (4 * self.elevations.n * self._azimuths[0].size), 1)
        parts = [
            self._rows(sin[i : i + step], z[i : i + step], side) for i in range(0, z.size, step)
        ]
        return Scattered(*(np.concatenate(part, axis=1) for part in zip(*parts, strict=True)))

    def _rows(self, sin: Array, z: Array, side: int) -> tuple[Array, Array]:
        """The part of the rows that is seen from a few directions."""
        eta = self.eta(side)
        total = np.zeros((2, self.modes, z.size, 2 * self.elevations.n))
        for event, low, high in _elevations_after(sin, z, eta):
            hemispheres = []
            for sign in (-1, 1):
                ends = np.sort(np.maximum([sign * low, sign * high], 0), axis=0)
                angle = self.elevations.between(*abscissa(ends))
                q = self._modes(sin, z, angle, sign, eta, event) * angle.weight[..., None]
                matrix = self.elevations.interpolation(angle.x)
                hemispheres.append(np.swapaxes(q, -1, -2) @ matrix)
            total[event] += np.moveaxis(np.concatenate(hemispheres, axis=-1), 1, 0)
        return self._complete(total[0], total[1], sin, z)

    def _complete(
        self, reflected: Array, transmitted: Array, sin: Array, z: Array
    ) -> tuple[Array, Array]:
        """Scale what is transmitted so that nothing is lost: reflection, whose quadrature is the
        more accurate one, and transmission share sigma."""
        share = self.slopes.sigma(np.array([sin, 0 * sin, z])) - reflected[0].sum(-1)
        total = transmitted[0].sum(-1)
        scale = np.divide(share, total, out=np.zeros_like(share), where=total > 0)
        return reflected, transmitted * scale[:, None]

    @cached_property
    def _azimuths(self) -> tuple[Array, Array]:
        phi, weight = azimuths(self.modes, AZIMUTHS)
        return phi, 2 * weight[:, None] * np.cos(np.multiply.outer(phi, np.arange(self.modes)))

    def _modes(
        self, sin: Array, z: Array, angle: Angles, sign: int, eta: float, event: int
    ) -> Array:
        """Modes (rows, n, modes) of q from directions (rows,) to elevations (rows, n)."""
        phi, factors = self._azimuths
        shape = (*angle.sin.shape, phi.size)
        w, d = np.empty((3, *shape)), np.zeros((3, *shape))
        w[0] = angle.sin[..., None] * np.cos(phi)
        w[1] = angle.sin[..., None] * np.sin(phi)
        w[2] = sign * angle.cos[..., None]
        d[0], d[2] = sin[:, None, None], z[:, None, None]
        q = dielectric_density(self.slopes, eta, d.reshape(3, -1), w.reshape(3, -1))[event]
        modes: Array = q.reshape(shape) @ factors
        return modes

    def follow(self, wi: Array, orders: int) -> Flights:
        """Light that leaves each facet, for arrival from `wi` (3,): orders 1 to `orders`, then
        the sum of all later ones."""
        sigma = self.slopes.sigma(-wi[:, None])
        rows = self.rows(np.hypot(wi[:1], wi[1:2]), -wi[2:], 0)
        h = self.heights.arrive(sigma / wi[2])[0]
        outside = h[:, None] * rows.reflected / sigma
        inside = h[::-1, None] * rows.transmitted / sigma
        leaving = [np.stack([outside, inside], axis=1)]
        while len(leaving) < orders:
            leaving.append(self._collide(self.fly(leaving[-1])))
        return self._settle(leaving)

    def _settle(self, leaving: list[Array]) -> Flights:
        """Sum the later orders until the energy that leaves no longer counts, beyond rounding."""
        last = self._collide(self.fly(leaving[-1]))
        rest = np.zeros_like(last)
        rounding = np.finfo(float).eps
        while True:
            rest = rest + last
            # Interpolation makes ripples of either sign, but not more light than has come in.
            if not np.abs(last[0]).sum() < 2:
                raise ArithmeticError("energy grows from order to order: `resolution` is too low")
            if np.abs(last[0].sum()) <= rounding * np.abs(rest[0].sum()):
                return Flights([*leaving, rest], float(np.abs(last[0].sum())))
            last = self._collide(self.fly(last))

    def fly(self, leaving: Array) -> Array:
        """From light that leaves facets to light that meets the next ones."""
        each = np.moveaxis(leaving, -1, 0)
        met = each.reshape(len(each), -1, self.heights.n) @ self.paths
        return np.moveaxis(met.reshape(each.shape), 0, -1)

    def _collide(self, met: Array) -> Array:
        outside, inside = self.kernels
        after = np.empty_like(met)
        after[:, 0] = met[:, 0] @ outside.reflected + met[:, 1, ::-1] @ inside.transmitted
        after[:, 1] = met[:, 1] @ inside.reflected + met[:, 0, ::-1] @ outside.transmitted
        return after

    def emerge(self, flights: Flights, sin: Array, cos: Array, side: int) -> Array:
        """Modes (orders, modes, rows) of the light that leaves on a side in upward directions
        of sine and cosine (rows,): orders 2 to K and the rest, times cos.

        The last facet is seen from where the light goes, by reciprocity: rows from the reversed
        direction are what the nodes contribute, however sharply that depends on direction.
        """
        n = self.elevations.n
        back = self.rows(sin, -cos, side)
        seen = self.sigma * self.weight
        same, other = (
            _share(np.roll(r, n, axis=-1), seen) for r in (back.reflected, back.transmitted)
        )
        other = other * self.eta(1 - side) ** 2
        Lambda = self.slopes.sigma(np.array([sin, 0 * sin, cos])) / cos
        chance = self.heights.escape(Lambda)
        met = [self.fly(f) for f in self._before_last(flights)]
        values = []
        for f in met:
            first = np.swapaxes(same @ np.swapaxes(f[:, side], -1, -2), 1, 2)
            second = np.swapaxes(other @ np.swapaxes(f[:, 1 - side, ::-1], -1, -2), 1, 2)
            values.append(np.einsum("mhr,rh->mr", first + second, chance))
        return np.stack(values)

    @staticmethod
    def _before_last(flights: Flights) -> list[Array]:
        """What precedes orders 2 to K, and all later ones: order K and its followers."""
        *early, last, rest = flights.leaving
        return [*early, last + rest]

    def energy(self, flights: Flights) -> Array:
        """Energy (sides, orders + 1) that leaves after each facet."""
        up = self.elevations.n
        chance = self.heights.escape(self.extinction[up:]).T
        return np.stack([np.sum(f[0, :, :, up:] * chance, axis=(1, 2)) for f in flights.leaving], 1)


def _share(q: Array, sigma: Array) -> Array:
    """q / sigma; where no facet is seen, none is met."""
    share: Array = np.divide(q, sigma, out=np.zeros_like(q), where=sigma > 0)
    return share


def _elevations_after(sin: Array, z: Array, eta: float) -> list[tuple[int, Array, Array]]:
    """Ranges of elevations (rows,) after a reflection (event 0) and a transmission (event 1).

    Facets face up: a mirror raises directions, and the normal along sign(eta - 1) (d + eta w)
    bounds what is transmitted from below or from above; it also stays within the critical
    angle's complement of -d. Where reflection can be total, it is so within twice that angle of
    d, and a range ends where this circle does.
    """
    before, zenith = np.arctan2(z, sin), np.full_like(z, np.pi / 2)
    reach = np.arccos(min(eta, 1 / eta))
    low, high = np.maximum(-before - reach, -zenith), np.minimum(-before + reach, zenith)
    bound = np.arcsin(np.clip(-z / eta, -1, 1))
    if eta > 1:
        low = np.maximum(low, bound)
        return [(0, before, zenith), (1, np.minimum(low, high), high)]
    high = np.minimum(high, bound)
    # Beyond the zenith the circle comes down on the other side.
    top = before + 2 * reach
    top = np.clip(np.minimum(top, np.pi - top), before, zenith)
    return [(0, before, top), (0, top, zenith), (1, np.minimum(low, high), high)]
