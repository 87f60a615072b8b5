"""Reciprocity of the BSDF, for every method that claims it, [HHdD16 impl.] 4.4.2."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.random import Generator

from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.smith.walk import random_walk
from msbsdf_cli.statistics.multiple_testing import FAILS_AS_EXPECTED, Finding
from msbsdf_cli.statistics.test_statistics import Exact, TestStatistic
from msbsdf_cli.validation.batches import of_two
from msbsdf_cli.validation.bsdf import LIT, ORDERS, angles, drawn, hard, made
from msbsdf_cli.validation.configurations import IOR, Configuration
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.phase import BATCHES
from surfaces.facet import Array
from surfaces.materials import Conductor, Dielectric, Material

PILOT = 1 << 14
"""Walks that look for directions lit by second facets."""

LEAST_SECOND = 10
"""Walks of a batch that leave after their second facet, at least."""

ROUNDING = 1e-9
"""Relative rounding of a closed form seen from both ends."""

QUADRATURE_ERROR = 1e-4
"""Relative error of diffuse first orders, which are not symmetric to rounding."""


def reciprocity(c: Configuration, n: int, rng: Generator) -> Iterator[Finding]:
    """f(wi, wo) = f(wo, wi), all orders together and the second alone; through the surface with
    the squared index, since light here carries energy."""
    if not METHODS[c.method].traits.reciprocal:
        return
    if made(c) is None:
        return
    wo = lit_by_second(c, n, rng)
    if wo is None:
        return
    c = replace(c, wo=angles(wo))
    there, back = both_ways(c, n, rng)
    rows = {"reciprocity": slice(None), "reciprocity, order 2": slice(1, 2)}
    for name, orders in rows.items():
        one, two = there[:, orders].sum(axis=1), back[:, orders].sum(axis=1)
        if c.method == "single" and name != "reciprocity":
            continue
        yield Finding(name, "4.4.2", c, _evidence(c, one, two))


def lit_by_second(c: Configuration, n: int, rng: Generator) -> Array | None:
    """A direction (3, 1) that some walk takes after its second facet, or None where second facets
    are so rare, from either end, that a batch of `n` walks would hardly meet them: its scatter
    would then say nothing of its error. It is decided by walks of its own, so that no result can
    bear on it."""
    material = c.facets
    w = _after_second(c, material, c.i, rng)
    lit = w[:, np.abs(w[2]) > LIT]
    if lit.size == 0:
        return None
    wo = lit[:, rng.integers(lit.shape[1], size=1)]
    if METHODS[c.method].deterministic:
        return wo
    turned, above = (material, wo) if wo[2, 0] > 0 else (Dielectric(1 / IOR), -wo)
    rarest = min(w.shape[1], _after_second(c, turned, above, rng).shape[1])
    return wo if rarest / PILOT * n >= LEAST_SECOND * BATCHES else None


def _after_second(c: Configuration, material: Material, w: Array, rng: Generator) -> Array:
    """Directions (3, k) in which walks from w (3, 1) leave after their second facet."""
    pilot = random_walk(c.slopes, material, w[:, 0], PILOT, rng, 2)
    second = [light.w for light in pilot if light.order == 2 and light.resolved]
    return np.concatenate([np.empty((3, 0)), *second], axis=1)


def _evidence(c: Configuration, one: Array, two: Array) -> TestStatistic:
    slack, because = ROUNDING, "rounding"
    if not c.facets.specular:
        slack, because = QUADRATURE_ERROR, "quadrature over diffuse facets"
    elif (traits := METHODS[c.method].traits).energy_error and c.facets.transmits:
        slack, because = traits.slack(c.facets.name), "tables of albedos of both indices"
    slack *= float(one.mean())
    if one.size == 1 and two.size == 1:
        return Exact(float(one.mean()), float(two.mean()), slack, because)
    return of_two(one, two, slack, because)


def both_ways(c: Configuration, n: int, rng: Generator) -> tuple[Array, Array]:
    """f(wi, wo) and what the other way says of it, (batches, orders + 1) each; one batch where
    there is no noise."""
    slopes, material = c.slopes, c.facets
    there = METHODS[c.method](slopes, material, ORDERS)
    wi, wo = c.i, c.o
    back, turn, ratio = there, 1.0, abs(float(wo[2, 0]))
    if wo[2, 0] < 0:
        # Upside down, light that comes back from inside arrives from above on the inverse index.
        back, turn = METHODS[c.method](slopes, Dielectric(1 / IOR), ORDERS), -1.0
        ratio *= IOR**2
    size = max(n // BATCHES, 2)
    ways = []
    for method, a, b, scale in (
        (there, wi, wo, 1.0),
        (back, turn * wo, turn * wi, ratio / float(wi[2, 0])),
    ):
        one = method.evaluate(a[:, 0], b, size, rng)
        runs = [one.value[0, :, 0]]
        while one.stderr.any() and len(runs) < BATCHES:
            runs.append(method.evaluate(a[:, 0], b, size, rng).value[0, :, 0])
        ways.append(np.array(runs) * scale)
    return ways[0], ways[1]


def failing(c: Configuration, n: int, rng: Generator) -> Iterator[Finding]:
    """The height-correlated position-free model is not reciprocal ([WJFYHY22 supp.] 2.2)."""
    there, back = both_ways(c, n, rng)
    evidence = of_two(there[:, 1], back[:, 1])
    section = "[WJFYHY22 supp.] 2.2"
    yield Finding("reciprocity, order 2", section, c, evidence, FAILS_AS_EXPECTED)


def not_reciprocal() -> list[Configuration]:
    """Pairs of directions for which the two ways differ by a tenth and more."""
    method = "position-free-correlated"
    return [
        Configuration(slopes, (0.2, 0.0), wo, Conductor(), method)
        for slopes in (Beckmann(1.0, 1.0), Ggx(1.0, 1.0))
        for wo in ((1.3, 2.0), (1.2, 3.0))
    ]


IDENTITIES = (
    Identity(reciprocity, hard, drawn, draws=18, thin=4, share=0.1, least=10_000, cost=3),
    Identity(failing, not_reciprocal, thin=3, share=0.5, least=20_000, cost=3),
)
