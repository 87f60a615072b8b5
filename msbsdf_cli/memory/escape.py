"""The probability of leaving the surface, tabulated: four numbers serve every roughness.

What is tabulated is the logarithm of c times the integral of the hazard along the whole ray, which
is smooth and bounded, over the height of the facet, the slope c of the ray, what that is above the
facet's slope, and the facet's curvature. It is computed on few nodes and put on more by splines
that keep it monotone, so that it may be linear between these.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import PchipInterpolator

from msbsdf_cli.memory.correlation import correlation
from msbsdf_cli.memory.march import march
from surfaces.facet import Array
from surfaces.spectrum import Spectrum

HIGHEST = 6.0
"""Standard deviations within which all facets are."""
STEEPEST = 6.5
"""Slope in standard deviations above which rays meet nothing but what is next to their facet."""
LEAST = 1e-4
"""Slope of a ray below which the integral goes as 1 / c."""
BEND = 0.3, 0.15
"""Slopes of rays, and differences, are spaced evenly up to about these, and then as logarithms."""
CURVED = 3.5
"""Deviations within which curvatures are."""
COMPUTED = 33, 25, 25, 10
SIZE = 65, 49, 49, 19
"""Nodes of either kind, of heights, slopes, differences and curvatures. Over normal numbers of
these, probabilities are right to .004 nine times in ten; rays that all but touch their facet are
where they are not."""
BLOCK = 1 << 14
NONE = 1e-10
"""Smallest integral told apart from none."""
ALL, LEVEL = 16.0, 0.05
"""Largest, of rays that climb; of those of a lesser slope than `LEVEL` that over the slope, as it
is where they meet what is far away."""


@dataclass(frozen=True, eq=False)
class Escape:
    """Table (heights, slopes, differences, curvatures) of ln(c H) for rays of slope c > 0."""

    table: Array

    def hazard(self, h: Array, c: Array, delta: Array, u: Array) -> Array:
        """Integral of the hazard along rays from height `h` with slope `c`, greater than that of
        their facet by `delta`, whose curvature is `u`; they broadcast against each other. Infinite
        for c <= 0."""
        n_h, n_c, n_d, n_u = self.table.shape
        up = np.maximum(c, 0)
        i, x = _cell((h + HIGHEST) * ((n_h - 1) / (2 * HIGHEST)), n_h)
        j, y = _cell(np.log1p(up * (1 / BEND[0])) * ((n_c - 1) / MOST[0]), n_c)
        k, z = _cell(np.log1p(np.maximum(delta, 0) * (1 / BEND[1])) * ((n_d - 1) / MOST[1]), n_d)
        o, w = _cell((u + CURVED) * ((n_u - 1) / (2 * CURVED)), n_u)
        flat = self.table.ravel()
        first = ((i * n_c + j) * n_d + k) * n_u + o
        step = n_c * n_d * n_u, n_d * n_u, n_u
        row = []
        for corner in range(8):
            at = first + sum(s for bit, s in enumerate(step) if corner >> bit & 1)
            low = flat.take(at)
            row.append(low + (flat.take(at + 1) - low) * w)
        for share in (x, y, z):
            row = [a + (b - a) * share for a, b in zip(row[::2], row[1::2], strict=True)]
        # Above the table little is met, all of it far away: as little as Smith's t says.
        over = np.maximum(h, HIGHEST)
        thinner = np.exp((HIGHEST * HIGHEST - over * over) / 2) * (HIGHEST / over)
        with np.errstate(divide="ignore", over="ignore"):
            total: Array = np.exp(row[0]) * thinner / up
        return total

    def probability(self, h: Array, c: Array, delta: Array, u: Array) -> Array:
        """That nothing is met on such rays; 0 for c <= 0."""
        found: Array = np.exp(-self.hazard(h, c, delta, u))
        return found


MOST = np.log1p(STEEPEST / BEND[0]), np.log1p(2 * STEEPEST / BEND[1])


def _cell(place: Array, nodes: int) -> tuple[Array, Array]:
    """The node below a place, and how far it is behind."""
    place = np.clip(place, 0, nodes - 1).astype(np.float32, copy=False)
    node = np.minimum(place.astype(np.intp), nodes - 2)
    return node, place - node.astype(np.float32)


def axes(size: tuple[int, int, int, int] = SIZE) -> tuple[Array, Array, Array, Array]:
    """Heights, slopes of rays, differences and curvatures at the nodes."""
    h, u = (np.linspace(-most, most, n) for most, n in ((HIGHEST, size[0]), (CURVED, size[3])))
    c, delta = (
        bend * np.expm1(np.linspace(0, most, n))
        for bend, most, n in zip(BEND, MOST, size[1:3], strict=True)
    )
    return h, np.maximum(c, LEAST), np.maximum(delta, LEAST), u


def largest(c: Array) -> Array:
    """The largest integral told apart along rays of slope `c`."""
    return ALL * (1 + LEVEL / c)


@lru_cache(maxsize=2)
def escape(spectrum: Spectrum) -> Escape:
    """The table of surfaces of a spectrum."""
    h, c, delta, u = (a.ravel() for a in np.meshgrid(*axes(COMPUTED), indexing="ij"))
    facet = np.stack([delta, h, c - delta, u])
    most = largest(c)
    total = most.copy()
    for start in range(0, h.size, BLOCK):
        block = slice(start, start + BLOCK)
        _, away = march(correlation(spectrum, np.float64), facet[:, block], most[block])
        total[block][away.slot] -= away.left
    table = np.log(c * np.maximum(total, NONE)).reshape(COMPUTED)
    for axis, (few, many) in enumerate(zip(COMPUTED, SIZE, strict=True)):
        spline = PchipInterpolator(np.linspace(0, 1, few), table, axis)
        table = spline(np.linspace(0, 1, many))
    return Escape(np.ascontiguousarray(table, np.float32))
