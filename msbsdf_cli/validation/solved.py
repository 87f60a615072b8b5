"""The method without noise: energy, reciprocity and first order as exact as it says it is, and the
random walk against it, order by order, [HHdD16 impl.] 4.4."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.smith.walk import random_walk
from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.statistics.test_statistics import ChiSquare, Exact
from msbsdf_cli.validation import reference
from msbsdf_cli.validation.batches import of_batches
from msbsdf_cli.validation.configurations import GRAZING, Configuration
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.phase import BATCHES
from surfaces.facet import Array
from surfaces.materials import Conductor, Dielectric, Diffuse

ORDERS = 4

ROUNDING = 1e-6
"""Relative, of closed forms of the first order, as for the other methods."""

BEYOND = (2.0, 3.44)
"""Polar angle and azimuth of a direction beyond the surface: so near the horizon that the two sides
differ most."""

LATER = (2, 3)
"""Orders compared there: the first has its closed form."""

ROUGH = 1.0
"""Roughness from which walks see later orders often. On smoother surfaces these are rare and
bright, and the scatter of walks that have not met them says nothing of their error."""

LEAST_WALKS, WALK_COST = 100_000, 8
"""Walks of each method, at least; and walks without next events in the time of one with them."""

OWN = "the method's own estimate of its error, from two resolutions, and rounding"


def solved(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """One solution, asked for everything it can be asked for."""
    method = Solve(c.slopes, c.facets, ORDERS)
    energy = method.energy(c.i[:, 0])
    sides = np.stack([energy.reflected[0], energy.transmitted[0]])
    slack = float(energy.error.sum()) + 1e-12
    evidence = Exact(1.0, float(sides.sum()), slack, OWN)
    yield Finding("energy, without noise", "4.4.1", c, evidence)
    there, there_error = _value(method, c.i, c.o)
    back, back_error = _value(method, c.o, c.i)
    scale = float(c.o[2, 0] / c.i[2, 0])
    slack = float(there_error.sum() + scale * back_error.sum()) + ROUNDING * float(there.sum())
    evidence = Exact(float(there.sum()), scale * float(back.sum()), slack, OWN)
    yield Finding("reciprocity, without noise", "4.4.2", c, evidence)
    if c.facets.specular:
        closed = reference.single_scattering(c, c.i, c.o)
        slack = float(there_error[0]) + ROUNDING * closed
        evidence = Exact(closed, float(there[0]), slack, OWN)
        yield Finding("first order, without noise", "4.4.3", c, evidence)
    if c.facets.transmits and min(c.slopes.alpha) >= ROUGH:
        yield from _towards(c, method, n, rng)
    counts = _walked(c, n, rng)
    orders = ChiSquare.of_counts(counts.ravel(), n * sides.ravel(), "orders and sides")
    if orders is not None:
        yield Finding("energies of orders, walk against solve", "4.4.1", c, orders)


def _towards(
    c: Configuration, solution: Solve, n: int, rng: np.random.Generator
) -> Iterator[Finding]:
    """Orders of the walks towards a direction beyond the surface, where next events from within
    and from without have to know the side, against the solution."""
    c = replace(c, wo=BEYOND)
    wanted, error = _value(solution, c.i, c.o)
    size = max(n // WALK_COST, LEAST_WALKS) // BATCHES
    for name in ("walk", "walk-low-variance"):
        method = METHODS[name](c.slopes, c.facets, ORDERS)
        runs = [method.evaluate(c.i[:, 0], c.o, size, rng).value[0, :, 0] for _ in range(BATCHES)]
        for k in LATER:
            batches = np.array([run[k - 1] for run in runs])
            evidence = of_batches(float(wanted[k - 1]), batches, float(error[k - 1]), OWN)
            where = replace(c, method=name)
            yield Finding(f"order {k} through facets, against solve", "4.4", where, evidence)


def _value(method: Solve, wi: Array, wo: Array) -> tuple[Array, Array]:
    """f cos(theta_o) of each order and its error, (orders + 1,)."""
    found = method.evaluate(wi[:, 0], wo)
    return found.value[0, :, 0], found.stderr[0, :, 0]


def _walked(c: Configuration, n: int, rng: np.random.Generator) -> Array:
    """Walks (2, orders + 1) that leave on either side after each order."""
    counts = np.zeros((2, ORDERS + 1))
    for light in random_walk(c.slopes, c.facets, c.i[:, 0], n, rng, MAX_ORDER):
        below = np.count_nonzero(light.w[2] < 0)
        counts[:, min(light.order, ORDERS + 1) - 1] += light.w.shape[1] - below, below
    return counts


MAX_ORDER = 10_000


def hard() -> list[Configuration]:
    """All facets, both distributions, steep and grazing; two roughnesses for mirrors."""
    cases = [
        (Beckmann(0.5, 0.5), (GRAZING, 0.3), Conductor()),
        (Ggx(1.0, 1.0), (0.5, 0.3), Conductor()),
        (Ggx(1.0, 1.0), (GRAZING, 0.3), Dielectric()),
        (Ggx(1.0, 0.3), (0.8, 0.3), Conductor()),
        (Beckmann(1.0, 1.0), (0.0, 0.0), Diffuse()),
        (Beckmann(0.5, 0.5), (0.8, 0.3), Dielectric()),
        (Ggx(0.5, 0.5), (GRAZING, 0.3), Diffuse()),
    ]
    return [
        Configuration(slopes, wi, (0.9, 2.0), material=material, method="solve")
        for slopes, wi, material in cases
    ]


IDENTITIES = (Identity(solved, hard, thin=2, cost=3),)
