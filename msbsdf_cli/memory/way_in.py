"""What it says of the surface ahead that light came in from outside unhindered.

The way in, reversed, and the ray that leaves the first facet start from one point, psi apart as
seen from above. At distance x of the ray the hazard is multiplied by

    P(h(p) < l(p) | a crossing at x) / P(h(p) < l(p) | h(x) < l(x))

as where it looks back (`hazard`): p is a point of the way in and l(p) its height there, all given
the facet. Two points are tried, the nearest one, at x cos(psi), and one farther on, and the one
that says more is taken, as both say nearly the same. Where the two ways are one, nothing is met
above the way in: what a surface does not hide from one side, it does not hide from there, above.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from msbsdf_cli.memory import hazard, normal
from msbsdf_cli.memory.correlation import Correlation, correlation, derivatives
from msbsdf_cli.memory.frame import Directions
from msbsdf_cli.memory.hazard import Parts
from surfaces.facet import Array
from surfaces.spectrum import Spectrum

ANGLES = 128
"""Sines of angles between ways that are told apart."""

NEAR = 0.3
"""Distance below which two points are as correlated, given the facet, as they are there in the
same directions: both heights are off the parabola by the cube of the distance."""

NODES = 3000
"""Of the spline through the autocorrelation, denser towards 0, where short waves show."""

ROUNDING = 1e-12
"""Of variances."""

ABOVE = 6.0
"""Standard deviations above the surface at which a ray is not met, 1e-9 of the time."""

MOST = 1e6
"""Standard deviations that are as good as any more."""

REST = 1e-4
"""Least variance of a height that another one tells."""


@dataclass(frozen=True, eq=False)
class WayIn:
    """Correlations, given the facet, of a height on the way in with the height of the surface at a
    distance of the ray, and with its slope there given that, (points, sines, distances)."""

    spectrum: Spectrum
    farther: tuple[float, ...]
    """How much farther than the nearest point the points are."""
    first: int
    """Place in the lattice of the first distance."""
    height: Array
    slope: Array
    far: Array
    """The autocorrelation and its derivative on the lattice, (2, n), for where nothing is
    remembered of the facet."""

    def factor(self, rays: Array, h: Array, x: Array, after: Parts, place: Array | None) -> Array:
        """Of the hazard's parts `after` at distances `x` (n,) of rays from height `h`, at the
        lattice's `place`, None where nothing is remembered; `rays` is what `beside` has."""
        found = np.ones_like(x)
        some = np.flatnonzero((rays[0] > 0) & (after.b < ABOVE))
        if some.size == 0:
            return found
        cor = correlation(self.spectrum)
        cos, sin, delta, s, u = rays.take(some, axis=1)
        facet, x = np.stack([delta, h.take(some), s, u]), x.take(some)
        b, at_b, at_k = (a.take(some) for a in (after.b, after.at_b, after.at_k))
        M, narrower = normal.TRUNCATED.take(at_b), normal.NARROWER.take(at_b)
        k, scatter = normal.CROSSING.take(at_k), normal.SCATTER.take(at_k)
        least = np.zeros_like(x)
        for n, farther in enumerate(self.farther):
            t = x * cos + x.dtype.type(farther)
            if place is None:
                r1, r2 = self._forgotten(cor, x, t, cos, sin)
                with np.errstate(over="ignore"):
                    level = facet[1] + (s + delta) * t
            else:
                row = n * ANGLES + np.minimum((sin * ANGLES).astype(np.intp), ANGLES - 1)
                at = row * self.height.shape[2] + np.maximum(place.take(some) - self.first, 0)
                r1, r2 = self.height.ravel().take(at), self.slope.ravel().take(at)
                with np.errstate(over="ignore"):
                    level = hazard.linear(cor.distances[0], cor.index(t), facet)
            # A way in as good as vertical is above everything.
            level = np.minimum(level, MOST)
            rest = np.maximum(1 - r1 * r1 - r2 * r2 * (1 - scatter), REST)
            crossing = (level - r1 * b - r2 * k) / np.sqrt(rest)
            rest = np.maximum(1 - r1 * r1 * narrower, REST)
            free = (level + r1 * M) / np.sqrt(rest)
            ratio = normal.LOG_BELOW.take(normal.node(crossing))
            least = np.minimum(least, ratio - normal.LOG_BELOW.take(normal.node(free)))
        found[some] = np.exp(least)
        return found

    def likelihood(self, facet: Array, x: Array, before: Array) -> Array:
        """How much less likely, at most 1, light is to have come in by ways of which `before` is
        known, (5, n), to surfaces that rays cross at `x` (n,) than to others; for rays that leave
        facets of the four numbers `facet` (4, n)."""
        cor, share = correlation(self.spectrum), np.empty_like(x)
        level, c = facet[1] + (facet[0] + facet[2]) * x, facet[0] + facet[2]
        near, far = np.flatnonzero(x < cor.x[-1]), np.flatnonzero(x >= cor.x[-1])
        place = cor.index(x.take(near))
        parts = hazard.near(cor, place, facet.take(near, axis=1))
        for some, after, i in (
            (near, parts, place),
            (far, hazard.far(cor, level[far], c[far]), None),
        ):
            share[some] = self.factor(before[:, some], facet[1, some], x[some], after, i)
        return share

    def _forgotten(
        self, cor: Correlation, x: Array, t: Array, cos: Array, sin: Array
    ) -> tuple[Array, Array]:
        """The correlations where nothing is remembered of the facet, of points that are at `t` of
        the way in and `x` of the ray."""
        apart = np.hypot(x - t * cos, t * sin)
        R, slope = self.far.take(cor.index(apart), axis=1)
        return R, slope * (x - t * cos) / np.maximum(apart, np.finfo(x.dtype).tiny)


def beside(ray: Directions, back: Directions, delta: Array, u: Array) -> Array:
    """What is known of the ways `back` out of which light came to facets that rays leave: the
    cosine and sine of the angle between the two, by how much the way back is steeper than the
    facet, the facet's slope along it and its curvature, (5, ...) as they broadcast."""
    cos = ray.x * back.x + ray.y * back.y
    sin = np.minimum(np.abs(ray.x * back.y - ray.y * back.x), 1)
    return np.stack(np.broadcast_arrays(cos, sin, delta, back.c - delta, u))


@lru_cache(maxsize=2)
def way_in(spectrum: Spectrum) -> WayIn:
    """Those of surfaces of a spectrum."""
    cor = correlation(spectrum)
    lattice = cor.x.astype(float)
    first = int(np.searchsorted(lattice, NEAR)) - 1
    x = np.maximum(lattice[first:], NEAR)
    farther = 0.0, cor.lag
    grid = 2 * (lattice[-1] + cor.lag) * np.linspace(0, 1, NODES) ** 2
    spline = CubicSpline(grid, derivatives(spectrum, grid), axis=1)
    sin = ((np.arange(ANGLES) + 0.5) / ANGLES)[:, None]
    both = [correlations(spline, x, x * np.sqrt(1 - sin * sin) + more, sin) for more in farther]
    height, slope = (np.stack(a).astype(np.float32) for a in zip(*both, strict=True))
    far = np.asarray(spline(lattice)[:2], np.float32)
    return WayIn(spectrum, farther, first, height, slope, far)


def correlations(R: CubicSpline, x: Array, t: Array, sin: Array) -> tuple[Array, Array]:
    """Of the height at distance `t` in one direction with that at `x` in another, and with the
    slope there given the height; all given height, slopes and curvatures at 0. `R` is the
    autocorrelation and its first four derivatives."""
    cos, fourth = np.sqrt(1 - sin * sin), float(R(0.0)[4])
    p, (q, s) = _covariances(R, t)[0], _covariances(R, x)
    apart = np.hypot(x - t * cos, t * sin)
    value, bend = R(apart)[:2]
    pp, qq, ss = (np.maximum(1 - _told(a, a, 1.0, fourth), ROUNDING) for a in (p, q, s))
    qs = -_told(q, s, 1.0, fourth)
    pq = value - _told(p, q, cos, fourth)
    ps = bend * (x - t * cos) / apart - _told(p, s, cos, fourth)
    height = np.clip(pq / np.sqrt(pp * qq), -1, 1)
    slope = (ps - pq * qs / qq) / np.sqrt(pp * np.maximum(ss - qs * qs / qq, ROUNDING))
    # What the height leaves of the variance is the most that the slope tells.
    most = np.sqrt(1 - height * height)
    return height, np.clip(slope, -most, most)


def _covariances(R: CubicSpline, x: Array) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Of the height at `x`, and of the slope there, with four numbers at 0: the height, the sum of
    the curvatures, the slope, and how much larger the curvature is along than across."""
    R0, R1, R2, R3, _ = R(x)
    over = R1 / x
    turn = (R2 - over) / x
    return (R0, R2 + over, -R1, R2 - over), (R1, R3 + turn, -R2, R3 - turn)


def _told(a: tuple[Array, ...], b: tuple[Array, ...], cos: Array | float, fourth: float) -> Array:
    """The covariance of two numbers, in directions apart by `cos`, that those four account for."""
    # Of the sum of curvatures the variance is 8/3 `fourth`, and the covariance with the height -2;
    # of either part of their difference, which turns twice as fast, the variance is `fourth` / 3.
    total = 8 * fourth / 3
    level = (total * a[0] * b[0] + 2 * (a[0] * b[1] + a[1] * b[0]) + a[1] * b[1]) / (total - 4)
    turned = 2 * cos * cos - 1
    return np.asarray(level + a[2] * b[2] * cos + a[3] * b[3] * turned * (0.75 / fourth))
