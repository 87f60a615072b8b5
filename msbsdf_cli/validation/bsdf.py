"""The BSDF of every method: energy, samples, first order, heights, [HHdD16 impl.] 4.4."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from msbsdf_cli.methods.protocol import Method, UnsupportedError
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.methods.single import phase_density
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.statistics.test_statistics import Exact, TestStatistic
from msbsdf_cli.validation import reference
from msbsdf_cli.validation.batches import of_batches, of_two
from msbsdf_cli.validation.configurations import (
    GRAZING,
    LOSSLESS,
    Configuration,
    random_above,
    random_facets,
)
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.phase import BATCHES
from msbsdf_cli.validation.visible_normals import MOMENTS, moments
from surfaces.facet import Array, unit_circle

ORDERS = 2

FIRST_SHARE = 0.75
"""Share of the outgoing directions that the first facet draws; the others are uniform, for the sake
of later facets."""

DIFFUSE_FEWER = 4
"""Directions for which there is one with diffuse facets: each costs a quadrature, and what they
send where is smooth. Otherwise there are as many directions as walks, both being noise."""

SAMPLE_COST = 16
"""Pairs of a walk and a direction in the time of one sample."""

LEAST_SCATTER = 1e-12


def sampled() -> list[str]:
    """Names of the methods that draw outgoing directions, which these identities need, by the
    model that they evaluate."""
    traits = ((name, method.traits) for name, method in METHODS.items())
    return [name for name, of in traits if of.samples and of.consistent]


def energy_and_samples(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """f cos(theta_o) sums to 1 over the sphere (4.4.1), and the method's own samples have the
    moments of its values (4.4.4)."""
    method = made(c)
    if method is None:
        return
    traits = METHODS[c.method].traits
    walks = max(int(np.sqrt(n / BATCHES)), 16)
    summed = _integrals(c, method, walks, rng)
    if traits.conserves_energy:
        evidence = of_batches(
            1.0, summed[:, 0], traits.slack(c.facets.name), traits.energy_error_because
        )
    else:
        albedo = float(first_order_albedo(c.slopes, c.facets, c.i)[0])
        evidence = of_batches(albedo, summed[:, 0], ALBEDO_ERROR, "quadrature of the albedo")
    yield Finding("energy", "4.4.1", c, evidence)
    size = max(n // (SAMPLE_COST * BATCHES), 16)
    sampled = np.array([_sampled(c, method, size, rng) for _ in range(BATCHES)])
    for k, name in enumerate(("1", *MOMENTS)):
        if sampled[:, k].std() < LEAST_SCATTER:
            # Every sample has the weight 1: that is the energy once more.
            continue
        evidence = of_two(summed[:, k], sampled[:, k])
        yield Finding(f"samples against values, E[{name}]", "4.4.4", c, evidence)


def made(c: Configuration) -> Method | None:
    """The configuration's method, or None where it does not hold or is not there."""
    try:
        method: Method = METHODS[c.method](c.slopes, c.facets, ORDERS)
    except (UnsupportedError, KeyError):
        return None
    return method


def _integrals(c: Configuration, method: Method, walks: int, rng: np.random.Generator) -> Array:
    """Estimates (batches, 1 + 6) of the integral of f cos(theta_o) times 1 and moments of wo."""
    batches = [_directions(c, walks, rng) for _ in range(BATCHES)]
    wi = c.i[:, 0]
    if method.deterministic:
        together = np.concatenate([w for w, _ in batches], axis=1)
        value = method.evaluate(wi, together, 0, rng).value[0].sum(axis=0)
        values = np.split(value, np.cumsum([w.shape[1] for w, _ in batches])[:-1])
    else:
        values = [method.evaluate(wi, w, walks, rng).value[0].sum(axis=0) for w, _ in batches]
    return np.array(
        [
            ((value / density) * np.concatenate([np.ones((1, value.size)), moments(w)])).sum(axis=1)
            for value, (w, density) in zip(values, batches, strict=True)
        ]
    )


def _directions(c: Configuration, walks: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Outgoing directions (3, n) and their density, n times a probability density.

    Directions come from the first facet and from the whole hemisphere in fixed proportion and
    count by the balance heuristic; both densities are known, and no bright direction is rarely
    drawn. A cosine lobe would: walks near the top send light to the horizon as well. For diffuse
    facets the hemisphere alone will do.
    """
    slopes, material = c.slopes, c.facets
    diffuse = not c.facets.specular
    n = walks // DIFFUSE_FEWER if diffuse else walks
    first = 0 if diffuse else int(FIRST_SHARE * n)
    m = slopes.visible_normals(c.i, first, rng)
    facet = material.scatter(np.repeat(-c.i, first, axis=1), m, None, rng)
    through = np.zeros(first, bool) if facet.transmitted is None else facet.transmitted
    # What stays below its side has no value; the density there need not be known.
    w = facet.d[:, through == (facet.d[2] < 0)]
    w = np.concatenate([w, _uniform(n - first, material.transmits, rng)], axis=1)
    sides = 2 if material.transmits else 1
    density = np.full(w.shape[1], (n - first) / (2 * np.pi * sides))
    if first:
        density += first * phase_density(slopes, material, c.i[:, 0], w)
    return w, density


def _uniform(n: int, both_sides: bool, rng: np.random.Generator) -> Array:
    """Uniform directions (3, n), stratified in height."""
    z = (np.arange(n) + rng.random(n)) / n
    cos_phi, sin_phi = unit_circle(n, rng)
    s = np.sqrt(1 - z * z)
    if both_sides:
        z = np.where(rng.random(n) < 0.5, -z, z)
    return np.stack([s * cos_phi, s * sin_phi, z])


def _sampled(c: Configuration, method: Method, n: int, rng: np.random.Generator) -> Array:
    """Means of the weight of samples, and of it times their moments, (1 + 6,)."""
    w, weight = method.sample(c.i[:, 0], n, rng)
    return np.append(weight[0].mean(), (weight[0] * moments(w)).mean(axis=1))


def first_order(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """The first bounce against the textbook's closed form (4.4.3): by formula, and as the mean
    of random walks cut off after one facet."""
    method = made(c)
    if method is None:
        return
    wo = lit_direction(c, rng)
    c = replace(c, wo=angles(wo))
    wi, wo = c.i[:, 0], c.o
    closed, slack, because = _closed_form(c, rng)
    one = method.evaluate(wi, wo, max(n // BATCHES, 2), rng)
    evidence: TestStatistic
    if one.stderr[0, 0, 0] == 0:
        evidence = Exact(closed, float(one.value[0, 0, 0]), slack * closed, because)
    else:
        runs = [one, *(method.evaluate(wi, wo, n // BATCHES, rng) for _ in range(BATCHES - 1))]
        values = np.array([run.value[0, 0, 0] for run in runs])
        evidence = of_batches(closed, values, slack * closed, because)
    yield Finding("first order", "4.4.3", c, evidence)


def _closed_form(c: Configuration, rng: np.random.Generator) -> tuple[float, float, str]:
    """The textbook's first order, its relative error and where that comes from.

    Diffuse facets have none; there it is a mean over all of the slopes that face both ways, times
    masking and shadowing, on a grid of its own.
    """
    correlated = METHODS[c.method].traits.correlated
    if not c.facets.specular:
        value = reference.diffuse_scattering(c, c.i, c.o, correlated)
        return value, DIFFUSE_ERROR, "quadrature over diffuse facets, the program's and this one"
    value = reference.single_scattering(c, c.i, c.o, correlated)
    return value, 1e-6, "rounding of half vectors and the error of Lambda"


def lit_direction(c: Configuration, rng: np.random.Generator) -> Array:
    """A direction (3, 1) that the first facet sends light to: towards others hardly any walk
    contributes, and the scatter of those few would be no measure of the error."""
    slopes, material = c.slopes, c.facets
    while True:
        m = slopes.visible_normals(c.i, TRIES, rng)
        w, _, through = material.scatter(np.repeat(-c.i, TRIES, axis=1), m, None, rng)
        leaves = np.abs(w[2]) > LIT
        leaves &= w[2] > 0 if through is None else through == (w[2] < 0)
        if leaves.any():
            return w[:, np.flatnonzero(leaves)[:1]]


def angles(w: Array) -> tuple[float, float]:
    """Polar angle and azimuth of a direction (3, 1)."""
    return float(np.arccos(np.clip(w[2, 0], -1, 1))), float(np.arctan2(w[1, 0], w[0, 0]))


TRIES = 64
LIT = 0.1
"""Cosine above which a direction of leaving is well lit: the probability to leave falls to 0
below."""

DIFFUSE_ERROR = 1e-3
"""Relative error of the quadrature over diffuse facets where it is in doubt, at grazing."""

ALBEDO_ERROR = 1e-3
"""Of first-order albedos by quadrature."""


def hard() -> list[Configuration]:
    """Every method and material: grazing, rough, and as anisotropic as can be drawn."""
    cases = [
        (Beckmann(1.0, 1.0), (GRAZING, 0.3)),
        (Ggx(2.0, 2.0), (0.5, 0.0)),
        (Ggx(1.0, 0.1), (1.0, 0.7)),
    ]
    return [
        Configuration(slopes, wi, material=material, method=method)
        for method in sampled()
        for material in LOSSLESS
        for slopes, wi in cases
    ]


def drawn(rng: np.random.Generator) -> Configuration:
    """Any method, material, slopes and direction above the surface."""
    c = replace(random_above(rng), wo=None, heights="")
    return replace(c, material=random_facets(rng), method=str(rng.choice(sampled())))


IDENTITIES = (
    Identity(energy_and_samples, hard, drawn, draws=18, thin=4, share=3.0, cost=8),
    Identity(first_order, hard, drawn, draws=24, thin=4, share=0.05, cost=1),
)
