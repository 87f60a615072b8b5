"""Masking and shadowing from walked heights, [HHdD16 impl.] 4.1.1 to 4.1.5.

A point of the surface has a height that is random, or that of the first facet met from wi; a free
path from there leaves the surface or not. Expected probabilities come from Lambda as an integral
over slopes, so that the program's Lambda, its heights and its free paths are all on trial."""

from collections.abc import Callable, Iterator

import numpy as np
from scipy.special import beta, ndtri

from msbsdf_cli.smith.heights import HEIGHTS
from msbsdf_cli.smith.walk import exponential, flip, free_path
from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.statistics.test_statistics import Share
from msbsdf_cli.validation.configurations import Configuration, hard_above, random_above
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.reference import AREA_ERROR, big_lambda
from surfaces.facet import Array

BLOCK = 1 << 17
"""Trials drawn at once."""

LEAST = 1_000_000
"""Trials that tell a Lambda that is 1 % off: the probability to leave is (1 + Lambda)^-1, and such
an error moves it by up to .0025, five standard errors and in transmission six to seven."""

SLACK = "error of the integral over slopes behind Lambda"


def random_heights(c: Configuration, n: int, rng: np.random.Generator) -> Array:
    """Coordinates t = -ln C1(h) of points whose heights h follow the distribution."""
    U = rng.random(n)
    h = ndtri(U) if c.heights == "gaussian" else 2 * U - 1
    return HEIGHTS[c.heights].t(h)


def first_heights(c: Configuration, n: int, rng: np.random.Generator) -> Array:
    """Coordinates t of the facets that light from wi meets first: from t = 0, above all facets."""
    sigma = c.slopes.sigma(-c.i)
    return free_path(np.zeros(n), -c.i, sigma, exponential(n, rng, np.float64))[1]


def leaves(c: Configuration, t: Array, w: Array, rng: np.random.Generator) -> Array:
    """Who leaves the surface along w (3, 1) from t (n,)."""
    return free_path(t, w, c.slopes.sigma(w), exponential(t.size, rng, np.float64))[0]


def masking(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """1 / (1 + Lambda): Algorithm 8."""

    def trial(size: int) -> Array:
        return leaves(c, random_heights(c, size, rng), c.i, rng)

    yield _finding("masking", "4.1.1", c, 1 / (1 + big_lambda(c, c.i)), trial, n)


def masking_shadowing(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """1 / (1 + Lambda_i + Lambda_o), and the Beta function where wo is below: Algorithms 9, 10."""
    Lambda_i, Lambda_o = big_lambda(c, c.i), big_lambda(c, c.o)

    def reflected(size: int) -> Array:
        t = random_heights(c, size, rng)
        return leaves(c, t, c.i, rng) & leaves(c, t, c.o, rng)

    def transmitted(size: int) -> Array:
        t = random_heights(c, size, rng)
        return leaves(c, t, c.i, rng) & leaves(c, flip(t), c.o, rng)

    G2 = 1 / (1 + Lambda_i + Lambda_o)
    yield _finding("masking-shadowing", "4.1.2", c, G2, reflected, n)
    G2 = float(beta(1 + Lambda_i, 1 + Lambda_o))
    yield _finding("masking-shadowing, transmission", "4.1.3", c, G2, transmitted, n)


def shadowing_given_masking(
    c: Configuration, n: int, rng: np.random.Generator
) -> Iterator[Finding]:
    """G2 / G1 from the heights that are seen from wi: Algorithms 11 and 12."""
    Lambda_i, Lambda_o = big_lambda(c, c.i), big_lambda(c, c.o)

    def reflected(size: int) -> Array:
        return leaves(c, first_heights(c, size, rng), c.o, rng)

    def transmitted(size: int) -> Array:
        return leaves(c, flip(first_heights(c, size, rng)), c.o, rng)

    share = (1 + Lambda_i) / (1 + Lambda_i + Lambda_o)
    yield _finding("shadowing given masking", "4.1.4", c, share, reflected, n)
    share = float((1 + Lambda_i) * beta(1 + Lambda_i, 1 + Lambda_o))
    yield _finding("shadowing given masking, transmission", "4.1.5", c, share, transmitted, n)


def _finding(
    name: str,
    section: str,
    c: Configuration,
    expected: float,
    trial: Callable[[int], Array],
    n: int,
) -> Finding:
    """How often the trial comes true, against its probability."""
    count = sum(int(np.count_nonzero(trial(min(BLOCK, n - start)))) for start in range(0, n, BLOCK))
    evidence = Share(min(expected, 1.0), count, n, 10 * AREA_ERROR, SLACK)
    return Finding(name, section, c, evidence)


IDENTITIES = tuple(
    Identity(measure, hard_above, random_above, draws=6, least=LEAST)
    for measure in (masking, masking_shadowing, shadowing_given_masking)
)
