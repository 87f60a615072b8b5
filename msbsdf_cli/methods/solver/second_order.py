"""Order 2 of a dielectric, direction by direction.

The integral over the direction v between two facets is one over the facets that face either end of
the path, and then the other facet's q is in closed form; what happens to heights in between is
smooth, and only that is interpolated. Narrow lobes and their edges stay what they are, where two
that are both spread over nodes would not. From the third facet on, lobes have been mixed.

Both integrals are taken, each of its share: any two shares that sum to 1 will do, and here each
vanishes where the other facet's q is not smooth, or much the narrower one.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.solver.heights import Heights
from msbsdf_cli.methods.solver.nodes import SplitElevations, coordinate
from msbsdf_cli.methods.solver.slope_quadrature import SlopeQuadrature
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot
from surfaces.materials import Dielectric, Material

TINY = float(np.finfo(float).tiny)

EDGE = 4
"""Power by which a share vanishes at an edge: products with it have continuous derivatives up to
the third, and quadrature converges accordingly."""


@dataclass(frozen=True)
class Interpolation:
    """From values at the nodes (2 n,), downward and upward ones, to directions (lanes,)."""

    matrix: Array
    """From the nodes of either hemisphere (lanes, n)."""
    down: Array
    """Which directions lead downward (lanes,)."""

    def __call__(self, values: Array) -> Array:
        below, above = (self.matrix @ half for half in np.split(values, 2))
        return np.where(self.down, below, above)


@dataclass(frozen=True)
class Between:
    """Directions of travel (3, lanes) between the facets, on one side, chosen by the first."""

    v: Array
    amount: Array
    """q times the area that lanes stand for, over |cos| (1 + extinction)."""
    mis_weight: Array
    """That of the first facet."""
    interpolation: Interpolation
    """From values at the nodes."""


@dataclass(frozen=True)
class Arrival:
    """What the second facet needs to know of the first, for one direction of arrival."""

    d: Array
    """Direction of travel (3,)."""
    heights: Array
    """How much of what the first facet sends along the nodes, on either side, passes by each
    height, (sides, 2 n, heights), as `_paths` has it."""
    sides: tuple[Between, Between]


@dataclass(frozen=True)
class _Facet:
    """Facets of index `eta` behind over before that reflect (event 0) or transmit (event 1)."""

    slopes: Slopes
    eta: float
    event: int

    def q(self, d: Array, w: Array) -> tuple[Array, Array]:
        """q (lanes,) in closed form, and its weight for multiple importance sampling: it has edges
        where facets point to the horizon, and no limit where light is hardly deflected, and at
        either the half vector of length |w - d| or |d + eta w| does not rise; others where total
        reflection begins, or light no longer comes through."""
        interface = Dielectric(self.eta)
        if self.event == 1:
            q, h = interface.refraction(self.slopes, d, w), d + self.eta * w
            least: Array | float = np.abs(dot(w if self.eta < 1 else d, h)) / np.sqrt(
                np.maximum(dot(h, h), TINY)
            )
        else:
            q, h = interface.reflection(self.slopes, d, w)[0], w - d
            # Of total reflection the square of the cosine of incidence is 1 - eta^2.
            least = np.abs(dot(h, h) / 4 - (1 - self.eta**2)) if self.eta < 1 else 1.0
        return q, q / np.maximum(np.abs(h[2] * least), TINY ** (0.5 / EDGE)) ** EDGE


@dataclass(frozen=True)
class SecondOrder:
    """Two facets, and the way from the first to the second."""

    slopes: Slopes
    material: Material
    elevations: SplitElevations
    heights: Heights
    facets: SlopeQuadrature

    def arrive(self, wi: Array) -> Arrival:
        """For light from `wi` (3,)."""
        d = -wi
        sigma = self.slopes.sigma(d[:, None])
        h = self.heights.arrive(sigma / wi[2])[0] / sigma
        heights = np.stack([h @ self._paths, h[::-1] @ self._paths])
        outside, inside = (
            Between(
                light.w,
                light.amount / self._divisor(light.w),
                _Facet(self.slopes, self.material.ior, event).q(d[:, None], light.w)[1],
                self._interpolation(light.w),
            )
            for event, light in enumerate(self.facets.scatter(d, self.material.ior))
        )
        return Arrival(d, heights, (outside, inside))

    def emerge(self, arrivals: list[Arrival], w: Array, end: Array, side: int) -> Array:
        """Order 2 times cos of each arrival, (arrivals, n), along directions (3, n), upward on a
        side, that are `end` (3,) turned about the normal."""
        total = np.zeros((len(arrivals), w.shape[1]))
        eta = self.material.ior if side == 0 else 1 / self.material.ior
        probability = self.heights.escape(self.slopes.sigma(end[:, None]) / end[2])[0]
        for event, last in enumerate(self.facets.scatter(-end, eta)):
            # Backwards: where a transmission ends, light has come from, on the other side.
            before = side if event == 0 else 1 - side
            first = _Facet(self.slopes, self.material.ior, before)
            second = _Facet(self.slopes, eta, event)
            heights = probability if event == 0 else probability[::-1] / eta**2
            v = -last.w
            interpolation, divisor = self._interpolation(v), self._divisor(v)
            _, mis_weight_2 = second.q(-end[:, None], last.w)
            for k, arrival in enumerate(arrivals):
                near, turned = arrival.sides[before], _turned(arrival.d[:, None], w, end)
                passing = arrival.heights[before] @ heights
                from_end = last.amount * interpolation(passing) / divisor
                from_start = near.amount * near.interpolation(passing)
                for i in range(w.shape[1]):
                    q_1, mis_weight_1 = first.q(turned[:, i : i + 1], v)
                    total[k, i] += from_end @ _shared(q_1, mis_weight_1, mis_weight_2)
                    q, mis_weight = second.q(-w[:, i : i + 1], -near.v)
                    total[k, i] += from_start @ _shared(q, mis_weight, near.mis_weight)
        return total

    @cached_property
    def _paths(self) -> Array:
        """Free paths (2 n, heights, heights) downward and upward along the x-axis, per unit of
        extinction and times that plus 1: neither zero nor infinite anywhere."""
        nodes = self.elevations.nodes
        up = np.stack([nodes.sin, 0 * nodes.sin, nodes.cos])
        L, Lambda = (self.slopes.sigma(up * [[1], [1], [s]]) / nodes.cos for s in (-1, 1))
        extinction = np.concatenate([L, Lambda])[:, None, None]
        paths: Array = np.concatenate([self.heights.sink(L), self.heights.rise(Lambda)])
        return paths * (1 + extinction)

    def _interpolation(self, v: Array) -> Interpolation:
        """To directions (3, lanes): along the x-axis some direction has the same extinction."""
        a_x, a_y = self.slopes.alpha
        x = coordinate(np.hypot(a_x * v[0], a_y * v[1]), a_x * np.abs(v[2]))
        return Interpolation(self.elevations.interpolation(x), v[2] < 0)

    def _divisor(self, v: Array) -> Array:
        """|cos| (1 + extinction), (lanes,)."""
        divisor: Array = np.abs(v[2]) + self.slopes.sigma(v)
        return divisor


def _shared(q: Array, mis_weight: Array, other: Array) -> Array:
    """q of the facet that did not choose the lanes, times the share of the one that did."""
    total = mis_weight + other
    share: Array = np.divide(q * other, total, out=np.zeros_like(q), where=total > 0)
    return share


def _turned(d: Array, w: Array, end: Array) -> Array:
    """`d` (3, 1) turned about the normal as `w` (3, n) would have to be to become `end` (3,)."""
    phi = np.arctan2(d[1], d[0]) + np.arctan2(end[1], end[0]) - np.arctan2(w[1], w[0])
    sin = np.hypot(d[0], d[1])
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), np.broadcast_to(d[2], phi.shape)])
