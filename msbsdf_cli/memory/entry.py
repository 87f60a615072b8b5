"""Where light from outside meets its first facet.

The facet is at height h with slope s and curvature u where the surface is there, faces the light,
and the way back to the light is free: a density of phi(h) phi(u) times that of visible slopes times
the probability of escape back along the ray, by the same hazard as everywhere. Smith has
C1(h)^Lambda for the latter. As the hazard is an approximation, the density does not integrate to
the light that comes: it is divided by its integral, `normalisation`, so that no energy is lost or
made."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from msbsdf_cli.memory.escape import Escape, axes, escape, largest
from msbsdf_cli.memory.facets import facing
from msbsdf_cli.memory.frame import Directions
from msbsdf_cli.memory.normal import ROOT_2_PI, depth, excess, height
from surfaces.facet import Array
from surfaces.quadrature import gauss
from surfaces.spectrum import Spectrum

HALF = 0.5
"""Of Smith's Lambda is left to the heights that are proposed: they are broader than Smith's."""

NEARLY = 0.9
"""Of the largest integral that the table tells apart: what is beyond does not come in."""

HEIGHTS, SLOPES, BENDS = 120, 64, 16
"""Nodes of quadratures over entries."""


@dataclass(frozen=True, eq=False)
class Entry:
    """First facets of light from outside, for all directions."""

    escape: Escape
    c: Array
    bound: Array
    """Largest ratio of the density to that of the proposals, over slopes `c` of the ray."""

    def draw(self, ray: Directions, n: int, rng: np.random.Generator) -> tuple[Array, ...]:
        """Heights, slopes along the ray, slopes across and curvatures along (n,) of the facets that
        rays, downward and one for each or for all, meet first."""
        h, along, bend = np.empty((3, n), np.float32)
        up = np.broadcast_to(-ray.c, (n,)).astype(np.float32)
        lanes = np.arange(n)
        while lanes.size:
            c = up.take(lanes)
            broad = HALF * Lambda(c)
            t = rng.standard_exponential(lanes.size, dtype=np.float32) / (1 + broad)
            there, s = height(t).astype(np.float32), facing(-c, rng)
            u = rng.standard_normal(lanes.size, dtype=np.float32)
            ratio = np.exp(broad * t - self.escape.hazard(there, c, s + c, u))
            limit = rng.random(lanes.size, dtype=np.float32) * np.interp(c, self.c, self.bound)
            kept = limit < ratio
            for all_lanes, mine in ((h, there), (along, s), (bend, u)):
                all_lanes[lanes.compress(kept)] = mine.compress(kept)
            lanes = lanes.compress(~kept)
        return h, along, rng.standard_normal(n, dtype=np.float32), bend

    def normalisation(self, c: float) -> float:
        """The integral of the density for rays that come down at a slope -`c` < 0, over the light
        that comes; 1 if the hazard were exact."""
        h, weight = heights(HEIGHTS, c)
        delta, area = slopes(c)
        u, share = bends(BENDS)
        free = self.escape.probability(h[:, None, None], np.array(c), delta[:, None], u)
        return float(weight @ (free @ share) @ area / c)


def Lambda(c: Array) -> Array:
    """Smith's Lambda of upward rays of slope `c`."""
    return excess(c) / np.maximum(c, np.finfo(c.dtype).tiny)


def heights(number: int, c: float) -> tuple[Array, Array]:
    """Nodes and weights over a normal distribution of heights, as dense as entries along a slope
    `c` are proposed: near the top where rays are level."""
    u, weight = gauss(number)
    scale = 1 + HALF * float(Lambda(np.array(c)))
    return height(-np.log(u) / scale), weight * u ** (1 / scale - 1) / scale


def bends(number: int) -> tuple[Array, Array]:
    """Nodes and weights over normal numbers, few for what is smooth."""
    x, weight = np.polynomial.hermite_e.hermegauss(number)
    return x, weight / weight.sum()


def slopes(c: float) -> tuple[Array, Array]:
    """Nodes and weights over what visible slopes have above -`c`, which sum to their area."""
    x, weight = gauss(SLOPES)
    low, high = max(-c, -8.0), 8.0
    s = low + (high - low) * x
    return s + c, (high - low) * weight * (s + c) * np.exp(-s * s / 2) / ROOT_2_PI


@lru_cache(maxsize=2)
def entry(spectrum: Spectrum) -> Entry:
    """That of surfaces of a spectrum."""
    table = escape(spectrum)
    h, c, _, _ = axes()
    total = np.exp(table.table.min(axis=(2, 3)).astype(float)) / c
    ratio = HALF * Lambda(c) * depth(h)[:, None] - total
    ratio[total > NEARLY * largest(c)] = 0
    return Entry(table, c, np.maximum(np.exp(ratio.max(axis=0)), 1))
