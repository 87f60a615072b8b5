"""Differences of the BSDF seen from both ends over many pairs of directions,
[WJFYHY22 supp.] figure 16: there of a picture, here of the two position-free models."""

from collections.abc import Iterator

import numpy as np

from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.scene import direction
from msbsdf_cli.smith.slopes import Ggx
from msbsdf_cli.statistics.multiple_testing import FAILS_AS_EXPECTED, HOLDS, Finding
from msbsdf_cli.validation.batches import of_batches
from msbsdf_cli.validation.configurations import Configuration
from msbsdf_cli.validation.identity import Identity
from surfaces.materials import Conductor

PAIRS = 500

LEAST_COSINE = 0.15
"""Directions further up are well lit, and their estimates nearly normal."""


def differences(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """Mean of f(wi, wo) - f(wo, wi) of the orders after the first, over pairs of which
    wi is the steeper direction: without that order, the mean of any model would be 0."""
    method = METHODS[c.method](c.slopes, c.facets, 1)
    size = max(n // PAIRS, 16)
    apart = np.empty(PAIRS)
    for k in range(PAIRS):
        a, b = _pair(rng)
        there = method.evaluate(a, b[:, None], size, rng).value[0, 1, 0] / b[2]
        back = method.evaluate(b, a[:, None], size, rng).value[0, 1, 0] / a[2]
        apart[k] = there - back
    wanted = HOLDS if METHODS[c.method].traits.reciprocal else FAILS_AS_EXPECTED
    section = "[WJFYHY22 supp.] fig. 16"
    name = "reciprocity, mean of differences"
    evidence = of_batches(0.0, apart)
    yield Finding(name, section, c, evidence, wanted, tuple(apart.tolist()))


def _pair(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Two directions (3,) above the surface, the steeper one first."""
    low, high = np.sort(rng.uniform(LEAST_COSINE, 1, 2))
    azimuths = rng.uniform(0, 2 * np.pi, 2)
    return direction(np.arccos(high), azimuths[0]), direction(np.arccos(low), azimuths[1])


def models() -> list[Configuration]:
    """Both models, and the walk beside them; roughness 1."""
    return [
        Configuration(Ggx(1.0, 1.0), (0.0, 0.0), None, Conductor(), method)
        for method in ("position-free-uncorrelated", "position-free-correlated", "walk")
    ]


IDENTITIES = (Identity(differences, models, share=0.5, least=20_000, cost=6),)
