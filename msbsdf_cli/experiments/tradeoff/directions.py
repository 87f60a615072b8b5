"""The outgoing directions in which methods are judged, with their share of solid angle."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.tradeoff.quasirandom import QuasiRandom
from msbsdf_cli.methods.single import Single, phase_density
from msbsdf_cli.scene import Scene
from surfaces.facet import Array
from surfaces.streams import seed_sequence

EVERYWHERE = 0.5
"""Share of the directions that are spread evenly over solid angle; the others follow the lobe, so
that one narrower than their mean distance is not missed."""


@dataclass(frozen=True)
class Lobe:
    """One incident direction and a quadrature over outgoing ones."""

    theta: float
    wi: Array
    wo: Array
    """Unit vectors (3, n)."""
    solid_angle: Array
    """Weights (n,): sums of weight times values are integrals over solid angle."""


def lobe_directions(scene: Scene, theta: float, n: int, seed: int) -> Lobe:
    """About `n` directions from the even mixture of uniform ones and those of the first facet.

    Both parts are Sobol points; what the facet sends where no light leaves is left out.
    """
    slopes, material, wi = scene.slopes, scene.material, scene.wi(theta)
    even = max(2, round(EVERYWHERE * n))
    rng = QuasiRandom(seed_sequence(seed, "lobe directions"))
    rng.begin()
    z, turn = rng.random(even), 2 * np.pi * rng.random(even)
    sides = 1 + material.transmits
    z = 1 - sides * z
    s = np.sqrt(np.maximum(1 - z * z, 0))
    uniform = np.stack([s * np.cos(turn), s * np.sin(turn), z])
    follow = max(2, n - even)
    rng.begin()
    along, _ = Single(slopes, material, 1).sample(wi, follow, rng)
    wo = np.hstack([uniform, along])
    leaves = wo[2] != 0 if material.transmits else wo[2] > 0
    wo = wo[:, leaves]
    total = even + follow
    lobe = phase_density(slopes, material, wi, wo)
    density = even / total / (2 * np.pi * sides) + follow / total * lobe
    return Lobe(theta, wi, wo, 1 / (total * density))
