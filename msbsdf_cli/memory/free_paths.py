"""Free paths from points of given heights, uniform over the mean plane where it faces the way."""

from collections.abc import Callable

import numpy as np
from scipy.special import ndtr, ndtri

from msbsdf_cli.memory.frame import Directions, directions
from msbsdf_cli.memory.next_facet import Memory, next_facets
from msbsdf_cli.memory.remembered import Remembered
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array


def shares(
    remembered: Remembered, slopes: Slopes, edges: Array
) -> Callable[[Array, float, int, np.random.Generator], Array]:
    """What draws, for a direction (3, 1), a height of start, infinite for rays from outside, and a
    number of rays, the shares (bins + 1,) that next meet heights between `edges`, and that
    escape."""
    memory = Memory.of(*remembered)

    def draw(d: Array, start: float, n: int, rng: np.random.Generator) -> Array:
        ray = directions(slopes, d)
        if np.isinf(start):
            met = _from_outside(memory, ray, n, rng)
        else:
            met = _from_height(memory, float(ray.c[0]), start, n, rng)
        # Heights beyond the outermost finite edges belong to the outermost bins.
        counts = np.histogram(np.clip(met, edges[1] - 1, edges[-2] + 1), edges)[0]
        return np.append(counts, n - met.size) / n

    return draw


def _from_outside(memory: Memory, ray: Directions, n: int, rng: np.random.Generator) -> Array:
    if ray.c[0] >= 0:
        return np.zeros(0)
    return memory.entry.draw(ray, n, rng)[0]


def _from_height(memory: Memory, c: float, start: float, n: int, rng: np.random.Generator) -> Array:
    """Heights met; slopes at the start are normal numbers below that of the ray."""
    c = float(np.clip(c, -STEEPEST, 1 / LEAST))
    s = ndtri((1 - rng.random(n)) * ndtr(c))
    bend = rng.standard_normal(n)
    facet = np.stack([np.maximum(c - s, LEAST), np.full(n, start), s, bend]).astype(np.float32)
    hits, _ = next_facets(memory, facet, rng)
    return hits.h


STEEPEST = 30.0
"""Standard deviations of slope: no facet faces a ray that falls more steeply, 1e-197 of the
time."""
LEAST = 1e-6
"""Difference of slopes that is none."""
