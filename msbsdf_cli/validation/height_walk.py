"""The BSDF does not depend on the distribution of heights, [HHdD16] Section 5 and 8.

The program walks in t = -ln C1(h) and has no heights. Here the walk is done a second time, in
heights, as [HHdD16 impl.] Algorithms 1 and 7 have it: with uniform ones and with Gaussian ones.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr, ndtri

from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.smith.walk import random_walk
from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.statistics.test_statistics import ChiSquare
from msbsdf_cli.validation.configurations import (
    GRAZING,
    LOSSLESS,
    Configuration,
    random_above,
    random_facets,
)
from msbsdf_cli.validation.identity import Identity
from surfaces.facet import Array

ORDERS = 6
"""Orders counted one by one; the later ones are one more."""

POLAR_BINS = 4
"""Bins in cos(theta_o) of each order on each side."""

MAX_ORDER = 10_000


def height_independence(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """Walks in heights against walks in t: how many leave after each facet, where to."""
    ours = np.zeros(_cells())
    for light in random_walk(c.slopes, c.facets, c.i[:, 0], 4 * n, rng, MAX_ORDER):
        if light.resolved:
            ours += _count(light.order, light.w[2])
    theirs = walk_in_heights(c, n, rng)
    because = f"orders 1 to {ORDERS} and later, by side and {POLAR_BINS} bins of cos(theta_o)"
    evidence = ChiSquare.of_two(ours, theirs, because)
    if evidence is not None:
        yield Finding("independence of the height distribution", "[HHdD16] 5, 8", c, evidence)


def _cells() -> int:
    return (ORDERS + 1) * 2 * POLAR_BINS


def _count(order: int, z: Array) -> Array:
    """Counts of light by order, side and cosine, (cells,)."""
    bins = np.floor((z + 1) * POLAR_BINS).astype(int).clip(0, 2 * POLAR_BINS - 1)
    counts = np.zeros((ORDERS + 1, 2 * POLAR_BINS))
    counts[min(order, ORDERS + 1) - 1] = np.bincount(bins, minlength=2 * POLAR_BINS)
    return counts.ravel()


@dataclass(frozen=True)
class _Law:
    """A height distribution and its inverse; heights start above all of the surface."""

    name: str

    @property
    def top(self) -> float:
        return 40.0 if self.name == "gaussian" else 1.0

    def C1(self, h: Array) -> Array:
        return ndtr(h) if self.name == "gaussian" else np.clip((h + 1) / 2, 0, 1)

    def inverse(self, U: Array) -> Array:
        return ndtri(U) if self.name == "gaussian" else 2 * U - 1


def walk_in_heights(c: Configuration, n: int, rng: np.random.Generator) -> Array:
    """Counts (cells,) of n walks by Algorithm 1's heights; inside a dielectric the surface is
    seen upside down, h -> -h."""
    slopes, material, law = c.slopes, c.facets, _Law(c.heights)
    d, h = np.repeat(-c.i, n, axis=1), np.full(n, law.top)
    side = np.ones(n)
    counts = np.zeros(_cells())
    for order in range(MAX_ORDER):
        w = d * side
        reached = _next(law, slopes.sigma(w) / w[2], h * side, rng)
        leaves = reached >= 1
        if order:
            counts += _count(order, d[2, leaves])
        d, side = d[:, ~leaves], side[~leaves]
        h = law.inverse(reached[~leaves]) * side
        if h.size == 0:
            break
        m = slopes.visible_normals(-d * side, h.size, rng)
        # Materials take normals and directions as a walk inside has them, point-reflected.
        inside = side < 0 if material.transmits else None
        w, _, transmitted = material.scatter(d * side, m, inside, rng)
        d = w * side
        if transmitted is not None:
            side = np.where(transmitted, -side, side)
    return counts


def _next(law: _Law, Lambda: Array, h: Array, rng: np.random.Generator) -> Array:
    """C1 of the next height, 1 and above for who leaves (Eq. 30)."""
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        reached = law.C1(h) / (1 - rng.random(h.size)) ** (1 / Lambda)
    # A facet at the very bottom, to rounding, is at the bottom.
    return np.maximum(reached, np.finfo(float).tiny)


def hard() -> list[Configuration]:
    """All materials, both height distributions: grazing, anisotropic, rough."""
    cases = [(Beckmann(1.0, 1.0), (GRAZING, 0.0)), (Ggx(2.0, 0.5), (0.6, 0.4))]
    return [
        Configuration(slopes, wi, material=material, heights=heights)
        for material in LOSSLESS
        for heights in ("uniform", "gaussian")
        for slopes, wi in cases
    ]


def drawn(rng: np.random.Generator) -> Configuration:
    """Anything from above."""
    material = random_facets(rng)
    return replace(random_above(rng), wo=None, material=material)


IDENTITIES = (Identity(height_independence, hard, drawn, draws=9, share=0.1, cost=2),)
