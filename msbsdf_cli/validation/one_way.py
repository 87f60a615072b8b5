"""The random walk itself, among facets that all send light one way: then its orders have laws in
closed form, from [HHdD16] Eqs. 26 to 30.

Energies of opaque facets cannot tell a walk whose free paths are all too long by one factor: of a
path through t from 0 to infinity only the order of its facets matters, and that has no scale. The
flip C1 -> 1 - C1 between the two sides of a facet has one: light that goes through shows it.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.special import beta

from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.smith.walk import random_walk
from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.statistics.test_statistics import ChiSquare, Share
from msbsdf_cli.validation.configurations import Configuration, random_above
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.reference import AREA_ERROR, big_lambda
from surfaces.facet import Array
from surfaces.materials import Material, Scattered
from surfaces.materials._material import Normals

ORDERS = 8
"""Orders counted one by one; the later ones are one more."""

FEWER = 4
"""Walks through a facet for one among mirrors: of these, a fault moves more than one figure."""

SECTION = "[HHdD16] Eq. 26-30"

LAMBDA = "error of the integral over slopes behind Lambda"


@dataclass(frozen=True)
class OneWay(Material):
    """Facets that send all light along `w` (3, 1), a direction above the side it then travels in:
    all of it through them, or all of it back."""

    w: Array
    transmits: bool

    def scatter(
        self, d: Array, m: Array, inside: Array | None, rng: np.random.Generator
    ) -> Scattered:
        n = m.shape[1]
        if self.transmits:
            # The walk turns light that changes sides point-reflected.
            return Scattered(np.repeat(-self.w, n, axis=1), transmitted=np.ones(n, bool))
        return Scattered(np.repeat(self.w, n, axis=1))

    def reflection(
        self, normals: Normals, d: Array, w: Array, inside: bool = False
    ) -> tuple[Array, Array | None]:
        """All light goes one way, and none of it has a density."""
        return np.zeros(np.broadcast_shapes(d.shape, w.shape)[1:]), None


def one_way(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """Light from wi meets facets that send it along wo, on its side or beyond.

    Its first facet has t exponential of the mean 1 / (1 + Lambda_i). Up from there, the number of
    further facets is Poisson of the mean Lambda_o t, and over t geometric. Through the facet, the
    share that leaves at once is (1 + Lambda_i) B(1 + Lambda_i, 1 + Lambda_o).
    """
    Lambda_i, Lambda_o = big_lambda(c, c.i), big_lambda(c, c.o)
    leaves = (1 + Lambda_i) / (1 + Lambda_i + Lambda_o)
    shares = leaves * (1 - leaves) ** np.arange(ORDERS)
    walks = n // FEWER
    counts = _orders(c, False, walks, ORDERS, rng)
    evidence = ChiSquare.of_counts(
        np.append(counts, walks - counts.sum()), walks * np.append(shares, 1 - shares.sum())
    )
    if evidence is not None:
        yield Finding("walk among one-way facets, orders", SECTION, c, evidence)
    expected = float((1 + Lambda_i) * beta(1 + Lambda_i, 1 + Lambda_o))
    count = int(_orders(c, True, n, 1, rng)[0])
    share = Share(min(expected, 1.0), count, n, 10 * AREA_ERROR, LAMBDA)
    yield Finding("walk through a one-way facet", SECTION, c, share)


def _orders(
    c: Configuration, through: bool, n: int, orders: int, rng: np.random.Generator
) -> Array:
    """How many of `n` walks leave after each order, (orders,)."""
    counts = np.zeros(orders)
    facets = OneWay(c.o, through)
    for light in random_walk(c.slopes, facets, c.i[:, 0], n, rng, orders):
        if light.resolved:
            counts[light.order - 1] += light.w.shape[1]
    return counts


def hard() -> list[Configuration]:
    """Directions whose Lambda is about 1, where the share through a facet tells most; and both of
    them grazing, where first facets are so near the top that any other start would show."""
    cases = [
        (Ggx(1.0, 1.0), (1.2, 0.0), (1.4, 2.0)),
        (Beckmann(1.0, 1.0), (1.57, 0.3), (1.57, 2.0)),
        (Beckmann(1.0, 1.0), (0.5, 0.0), (1.4, 2.0)),
        (Ggx(2.0, 0.5), (1.57, 0.3), (1.565, 2.0)),
    ]
    return [Configuration(slopes, wi, wo) for slopes, wi, wo in cases]


IDENTITIES = (Identity(one_way, hard, random_above, draws=6, share=0.5, least=1_000_000),)
