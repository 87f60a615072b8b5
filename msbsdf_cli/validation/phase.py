"""The phase functions of the facets: normalisation, reciprocity, sampling, [HHdD16 impl.] 4.3."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from msbsdf_cli.scene import direction
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.statistics.test_statistics import Exact
from msbsdf_cli.validation.batches import of_batches, of_two
from msbsdf_cli.validation.configurations import (
    IOR,
    LOSSLESS,
    Configuration,
    random_anywhere,
    random_direction,
    random_facets,
)
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.reference import SEEN, projected_area
from msbsdf_cli.validation.visible_normals import MOMENTS, moments
from surfaces.facet import Array
from surfaces.materials import Conductor

BATCHES = 128
"""Independent batches behind a standard error: so many tell their skewness, too."""

COPPER = Conductor(((1.02, 2.577),))

DIFFUSE_ERROR = 1e-6
"""Of the quadrature behind diffuse facets, over the largest value; see `smith.lune`."""

PAIRS = 128
"""Pairs of directions for reciprocity."""


def sphere(rows: int, rng: np.random.Generator) -> Array:
    """Directions (3, 2 rows^2), one at random in each of so many equal parts of the sphere."""
    i, j = np.divmod(np.arange(2 * rows * rows), 2 * rows)
    z = 1 - 2 * (i + rng.random(i.size)) / rows
    phi = (j + rng.random(j.size)) * np.pi / rows
    s = np.sqrt(1 - z * z)
    return np.stack([s * np.cos(phi), s * np.sin(phi), z])


def phase_moments(c: Configuration, n: int, rng: np.random.Generator) -> Array:
    """Integrals (batches, 1 + 6) of p(wi, w) times 1 and the moments of w over the sphere; what
    goes through a facet counts with the direction it really has."""
    slopes, material, d = c.slopes, c.facets, -c.i
    rows = max(int(np.sqrt(n / (2 * BATCHES))), 2)
    sums = np.zeros((BATCHES, 1 + len(MOMENTS)))
    for batch in range(BATCHES):
        w = sphere(rows, rng)
        for transmitted in (False, True) if material.transmits else (False,):
            q = material.density(slopes, d, w, transmitted=transmitted)[0]
            seen = -w if transmitted else w
            sums[batch, 0] += q.mean()
            sums[batch, 1:] += (q * moments(seen)).mean(axis=1)
    return 4 * np.pi * sums / slopes.sigma(d)[0]


def phase_function(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """It sums to 1 over the sphere (4.3.1), and facets met and scattered from follow it (4.3.3)."""
    slopes, material = c.slopes, c.facets
    if projected_area(c, c.i) < SEEN:
        return
    if not c.facets.specular:
        n = n // DIFFUSE_COST
    summed = phase_moments(c, n, rng)
    slack = DIFFUSE_ERROR if not c.facets.specular else 0.0
    because = "quadrature over the normals of diffuse facets"
    evidence = of_batches(1.0, summed[:, 0], slack, because)
    yield Finding("phase function, normalisation", "4.3.1", c, evidence)
    size = max(n // BATCHES, 1)
    sampled = np.empty((BATCHES, len(MOMENTS)))
    for batch in range(BATCHES):
        m = slopes.visible_normals(c.i, size, rng)
        w = material.scatter(np.repeat(-c.i, size, axis=1), m, None, rng).d
        sampled[batch] = moments(w).mean(axis=1)
    for k, name in enumerate(MOMENTS):
        evidence = of_two(summed[:, 1 + k], sampled[:, k], slack, because)
        yield Finding(f"phase function, E[{name}]", "4.3.3", c, evidence)


def reciprocity(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """sigma(-wi) p(wi, wo) = sigma(-wo) p(wo, wi) for directions over the whole sphere
    ([HHdD16] Eqs. 37 to 39), also through facets, where light counts the squared index."""
    slopes, material = c.slopes, c.facets
    i = np.concatenate([_unit(rng) for _ in range(PAIRS)], axis=1)
    o = np.concatenate([_unit(rng) for _ in range(PAIRS)], axis=1)
    there = material.density(slopes, -i, o)
    back = material.density(slopes, -o, i)
    yield _same(c, "phase function, reciprocity", there, back)
    if material.transmits:
        there = material.density(slopes, -i, o, transmitted=True)
        back = material.density(slopes, -o, i, inside=True, transmitted=True)
        yield _same(c, "phase function, reciprocity through facets", there, IOR**2 * back)


def _unit(rng: np.random.Generator) -> Array:
    return direction(*random_direction(rng))[:, None]


def _same(c: Configuration, name: str, there: Array, back: Array) -> Finding:
    """The largest difference over the largest value."""
    worst = float(np.abs(there - back).max() / np.abs(there).max())
    slack, because = 1e-9, "rounding of half vectors, over the largest value"
    if not c.facets.specular:
        slack, because = 10 * DIFFUSE_ERROR, "quadrature over the normals of diffuse facets"
    return Finding(name, "4.3.2, [HHdD16] Eq. 39", c, Exact(0.0, worst, slack, because))


DIFFUSE_COST = 1024
"""Directions of a mirror in the time of one of diffuse facets, which takes a quadrature."""


def hard() -> list[Configuration]:
    """Grazing, straight, up through the surface; rough, smooth and anisotropic; all facets."""
    cases = [
        (Beckmann(1.0, 1.0), (1.5, 0.3)),
        (Ggx(1.0, 1.0), (0.0, 0.0)),
        (Beckmann(2.0, 2.0), (2.2, 1.0)),
        (Ggx(2.0, 0.3), (1.8, 0.5)),
        (Beckmann(0.1, 0.1), (1.5, 0.0)),
    ]
    return [
        Configuration(slopes, wi, material=material)
        for material in LOSSLESS
        for slopes, wi in cases
    ]


def drawn(rng: np.random.Generator) -> Configuration:
    """Anything, of any material."""
    material = random_facets(rng)
    return replace(random_anywhere(rng), wo=None, heights="", material=material)


def hard_with_copper() -> list[Configuration]:
    """The same, and a metal, whose reflectance must be the same from both ends."""
    return [*hard(), Configuration(Ggx(0.6, 0.2), (0.5, 0.0), material=COPPER)]


IDENTITIES = (
    Identity(phase_function, hard, drawn, draws=9, share=2.0, cost=2),
    Identity(reciprocity, hard_with_copper, drawn, draws=6, cost=0.1),
)
