"""Light on a surface by samples of the BSDF, by samples of the lights, and by both, weighed by the
balance heuristic: one brightness, whatever finds it, [HHdD16] Section 9."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from msbsdf_cli.experiments.render.lights import Lamp, Lights
from msbsdf_cli.methods.protocol import Method
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.statistics.multiple_testing import Finding
from msbsdf_cli.validation.batches import of_two
from msbsdf_cli.validation.bsdf import angles, drawn, hard, lit_direction, made
from msbsdf_cli.validation.configurations import Configuration
from msbsdf_cli.validation.identity import Identity
from msbsdf_cli.validation.phase import BATCHES
from surfaces.facet import Array

KAPPA = 12.0
"""Of the lamp: some 17 degrees wide, so that both strategies have something to find."""
LAMP = (4.0, 4.0, 4.0)


def strategies(c: Configuration, n: int, rng: np.random.Generator) -> Iterator[Finding]:
    """Each strategy alone against both together, of independent samples."""
    method = made(c)
    if method is None or not METHODS[c.method].traits.pairs:
        return
    towards = lit_direction(c, rng)
    c = replace(c, wo=angles(towards))
    x, y, z = towards[:, 0].tolist()
    grey = (0.2, 0.2, 0.2)
    lights = Lights(grey, grey, (Lamp((x, y, z), KAPPA, LAMP),))
    size = max(n // BATCHES, 16)
    both = _brightness(method, c.i, lights, "mis", size, rng)
    for name in ("bsdf", "light"):
        alone = _brightness(method, c.i, lights, name, size, rng)
        yield Finding(f"samples of the {name}, and of both weighed", "9", c, of_two(alone, both))


def _brightness(
    method: Method, wi: Array, lights: Lights, strategy: str, n: int, rng: np.random.Generator
) -> Array:
    """Means (batches,) of `n` estimates each of the light that the surface sends to `wi`, in the
    first channel."""
    n *= BATCHES
    wi = np.repeat(wi, n, axis=1)
    total = np.zeros(n)
    if strategy != "light":
        w, weight = method.sample_each(wi, rng)
        share = 1.0 if strategy == "bsdf" else _share(method.pdf_each(wi, w), lights.pdf(w))
        total += weight[0] * share * lights.radiance(w)[0]
    if strategy != "bsdf":
        w = lights.sample(n, rng)
        density, other = lights.pdf(w), method.pdf_each(wi, w)
        share = 1.0 if strategy == "light" else _share(density, other)
        total += method.evaluate_each(wi, w, rng)[0] * share * lights.radiance(w)[0] / density
    return np.asarray(total.reshape(BATCHES, -1).mean(axis=1))


def _share(mine: Array, other: Array) -> Array:
    """The balance heuristic; a direction that neither would draw counts nothing."""
    return np.divide(mine, mine + other, out=np.zeros_like(mine), where=mine > 0)


IDENTITIES = (Identity(strategies, hard, drawn, draws=12, thin=4, share=0.25, cost=1),)
