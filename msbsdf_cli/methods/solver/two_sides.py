"""Dielectric interfaces: light on two sides that see the same surface from either end.

Light inside is kept point-reflected, so that both sides are half spaces above the same Smith
surface; a transmission changes sides, and C1 becomes 1 - C1. Heights do not integrate out, so
one arriving direction is followed facet by facet: the density of light that leaves a facet, over
heights x sides x directions ([HHdD16] Algorithm 1 with distributions in place of samples).
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from msbsdf_cli.methods.solver.heights import Heights
from msbsdf_cli.methods.solver.nodes import SplitElevations
from msbsdf_cli.methods.solver.slope_quadrature import Light, SlopeQuadrature
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material

TOGETHER = 64
"""Directions whose free paths are computed at a time: an array of some megabytes."""


class Spread(Protocol):
    """Directions as nodes and blocks (Fourier modes, or parities)."""

    @property
    def elevations(self) -> SplitElevations:
        """The nodes' elevations."""

    @property
    def half(self) -> bool:
        """Whether facets on either side of the plane of incidence count as the same."""

    @property
    def nodes(self) -> Array:
        """Upward directions (3, n); their images in the mean plane are the downward nodes."""

    @property
    def weight(self) -> Array:
        """Solid angles (n,) of the nodes in block 0, the one that carries the energy."""

    def spread(self, light: Light) -> Array:
        """Light (blocks, 2 n) at the nodes: downward ones, then upward ones."""

    def distinct(self, d: Array) -> tuple[Array, Array]:
        """Directions (3, m) for which to make rows, and which of them serves each of `d`."""

    def parting(self, a: Array, b: Array) -> Array:
        """Factors (blocks, n) that sum blocks to values from `a` (3, 1) to `b` (3, n)."""


MOST_FACETS = 10_000
"""Light that has met so many and still does not fade is not followed well: thousands are met by
light that an index near 1 hardly deflects."""


@dataclass(frozen=True)
class Scattered:
    """Scattering from some directions to the nodes, weights included.

    Arrays are (blocks, rows, 2 n): downward nodes, then upward ones.
    """

    reflected: Array
    transmitted: Array


@dataclass(frozen=True)
class Flights:
    """Light that leaves facets, as weights of sums over the nodes."""

    leaving: list[Array]
    """After the facets of order 1 to K, and summed over all later ones: (blocks, sides, heights,
    2 n)."""
    unresolved: float
    """Energy not followed to its end."""


@dataclass(frozen=True)
class TwoSides:
    """The discretised interface: kernels of both sides, free paths of both hemispheres."""

    slopes: Slopes
    material: Material
    directions: Spread
    heights: Heights
    facets: SlopeQuadrature

    @cached_property
    def nodes(self) -> Array:
        """Directions (3, 2 n) of the nodes: downward, then upward."""
        up = self.directions.nodes
        return np.concatenate([up * [[1], [1], [-1]], up], axis=1)

    @cached_property
    def weight(self) -> Array:
        """Solid angles (2 n,)."""
        return np.tile(self.directions.weight, 2)

    @cached_property
    def extinction(self) -> Array:
        """sigma / |cos| (2 n,) of the nodes' directions."""
        extinction: Array = self.slopes.sigma(self.nodes) / np.abs(self.nodes[2])
        return extinction

    @cached_property
    def paths(self) -> Array:
        """Free paths (2 n, heights, heights), per unit of extinction."""
        down, up = np.split(self.extinction, 2)
        parts = [
            fly(part)
            for fly, hemisphere in ((self.heights.sink, down), (self.heights.rise, up))
            for part in np.array_split(hemisphere, 1 + hemisphere.size // TOGETHER)
        ]
        return np.concatenate(parts)

    @cached_property
    def kernels(self) -> tuple[Scattered, Scattered]:
        """Scattering along each node's direction, on either side, per unit of height."""
        first, second = (self._kernel(side) for side in (0, 1))
        return first, second

    def _kernel(self, side: int) -> Scattered:
        rows, cos = self.rows(self.nodes, side), np.abs(self.nodes[2])[:, None]
        return Scattered(rows.reflected / cos, rows.transmitted / cos)

    def eta(self, side: int) -> float:
        """Index behind the facets over the index before them."""
        return self.material.ior if side == 0 else 1 / self.material.ior

    def rows(self, d: Array, side: int, finer: int = 1) -> Scattered:
        """Scattering from directions (3, rows), on one side, to the nodes; with more facets, where
        no sum over rows makes up for their errors."""
        facets = replace(self.facets, panel=finer * self.facets.panel)
        rows = [self._row(facets, d[:, i], self.eta(side)) for i in range(d.shape[1])]
        reflected, transmitted = (np.stack(part, axis=1) for part in zip(*rows, strict=True))
        # Nothing is lost, but for the quadrature: both together are sigma.
        found = reflected[0].sum(-1) + transmitted[0].sum(-1)
        scale = np.divide(self.slopes.sigma(d), found, out=np.zeros_like(found), where=found > 0)
        scale = scale[:, None]
        return Scattered(reflected * scale, transmitted * scale)

    def _row(self, facets: SlopeQuadrature, d: Array, eta: float) -> tuple[Array, Array]:
        reflected, transmitted = facets.scatter(d, eta)
        return self.directions.spread(reflected), self.directions.spread(transmitted)

    def follow(self, wi: Array, orders: int) -> Flights:
        """Light that leaves each facet, for arrival from `wi` (3,): orders 1 to `orders`, then
        the sum of all later ones."""
        d, _ = self.directions.distinct(-wi[:, None])
        sigma = self.slopes.sigma(d)
        # A single row, on which all else rests, and so at no cost a finer one.
        rows = self.rows(d, 0, finer=6)
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
        rest, ripples = np.zeros_like(last), 2 * np.abs(leaving[0][0]).sum()
        rounding = np.finfo(float).eps
        for _ in range(MOST_FACETS):
            rest = rest + last
            if np.abs(last[0]).sum() <= rounding * np.abs(rest[0]).sum():
                return Flights([*leaving, rest], float(np.abs(last[0].sum())))
            # Interpolation makes ripples of either sign, the more so the narrower the light, but
            # not more than there were to begin with.
            if not np.abs(last[0]).sum() < ripples:
                break
            last = self._collide(self.fly(last))
        raise ArithmeticError(
            "method solve lost light among too many facets; with an index near 1 at grazing "
            "angles, walk is the method to take"
        )

    def fly(self, leaving: Array) -> Array:
        """From light that leaves facets to light that comes by the next ones, per unit of
        extinction."""
        each = np.moveaxis(leaving, -1, 0)
        near = each.reshape(len(each), -1, self.heights.n) @ self.paths
        return np.moveaxis(near.reshape(each.shape), 0, -1)

    def _collide(self, near: Array) -> Array:
        outside, inside = self.kernels
        after = np.empty_like(near)
        after[:, 0] = near[:, 0] @ outside.reflected + near[:, 1, ::-1] @ inside.transmitted
        after[:, 1] = near[:, 1] @ inside.reflected + near[:, 0, ::-1] @ outside.transmitted
        return after

    def emerge(self, flights: list[Flights], w: Array, side: int) -> list[Array]:
        """Blocks (orders, blocks, rows) of the light of each of `flights` that leaves on a side in
        upward directions (3, rows): orders 3 to K and the rest, times cos.

        The last facet is seen from where the light goes, by reciprocity: rows from the reversed
        direction are what the nodes contribute, however sharply that depends on direction. Half
        a turn about the normal changes nothing, and makes reversals images in the mean plane.
        """
        back = self.rows(w * [[1], [1], [-1]], side, finer=2)
        n = self.weight.size // 2
        seen = np.abs(self.nodes[2]) * self.weight
        same, other = (np.roll(r, n, axis=-1) / seen for r in (back.reflected, back.transmitted))
        other = other * self.eta(1 - side) ** 2
        probability = self.heights.escape(self.slopes.sigma(w) / w[2])

        def left(leaving: Array) -> Array:
            f = self.fly(leaving)
            first = same @ np.swapaxes(f[:, side], -1, -2)
            second = other @ np.swapaxes(f[:, 1 - side, ::-1], -1, -2)
            return np.einsum("brh,rh->br", first + second, probability)

        return [np.stack([left(f) for f in self._before_last(each)]) for each in flights]

    @staticmethod
    def _before_last(flights: Flights) -> list[Array]:
        """What precedes orders 3 to K, and all later ones: order K and its followers, but for
        the first."""
        _, *later, rest = flights.leaving
        if later:
            later[-1] = later[-1] + rest
        return later or [rest]

    def energy(self, flights: Flights) -> Array:
        """Energy (sides, orders + 1) that leaves after each facet."""
        up = self.weight.size // 2
        probability = self.heights.escape(self.extinction[up:]).T
        return np.stack(
            [np.sum(f[0, :, :, up:] * probability, axis=(1, 2)) for f in flights.leaving], 1
        )
