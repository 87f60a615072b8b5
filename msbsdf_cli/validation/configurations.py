"""Configurations to measure identities in: drawn at random, and fixed hard ones."""

import math
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.scene import direction
from msbsdf_cli.smith.slopes import NAMES, Beckmann, Ggx, Slopes, distribution
from surfaces.facet import Array
from surfaces.materials import NAMES as MATERIALS
from surfaces.materials import Dielectric, Material, material

ROUGHNESS = (0.05, 2.0)
"""Least and largest roughness that is drawn, along either axis."""

IOR = Dielectric().ior

LOSSLESS: tuple[Material, ...] = tuple(
    facets for facets in (material(name)() for name in MATERIALS) if not facets.absorbs
)
"""Materials of which all light comes back, unless they are told otherwise."""

GRAZING = 1.5
"""Polar angle of the hard directions that graze the surface."""

Angles = tuple[float, float]
"""Polar angle and azimuth, in radians."""


@dataclass(frozen=True)
class Configuration:
    """Slopes, directions, facets: as far as an identity speaks of them."""

    slopes: Slopes
    wi: Angles
    wo: Angles | None = None
    material: Material | None = None
    method: str = ""
    heights: str = ""
    drawn: str = "fixed"
    """`fixed` or `random`."""

    @property
    def facets(self) -> Material:
        """The material, of identities that speak of one."""
        assert self.material is not None
        return self.material

    @property
    def i(self) -> Array:
        """The direction wi, (3, 1)."""
        return direction(*self.wi)[:, None]

    @property
    def o(self) -> Array:
        """The direction wo, (3, 1)."""
        assert self.wo is not None
        return direction(*self.wo)[:, None]


def random_slopes(rng: np.random.Generator) -> Slopes:
    """A distribution and its roughness along either axis, uniform in the logarithm."""
    low, high = np.log(ROUGHNESS)
    alpha = np.exp(rng.uniform(low, high, 2)).tolist()
    slopes: Slopes = distribution(str(rng.choice(NAMES)))(*alpha)
    return slopes


def random_facets(rng: np.random.Generator) -> Material:
    """One of the lossless materials."""
    return LOSSLESS[rng.integers(len(LOSSLESS))]


def random_direction(rng: np.random.Generator, low: float = -1.0) -> Angles:
    """Uniform over the sphere, above the polar cosine `low`."""
    return math.acos(rng.uniform(low, 1)), float(rng.uniform(0, 2 * math.pi))


def random_above(rng: np.random.Generator) -> Configuration:
    """Slopes, two directions above the surface and a height distribution."""
    return random_anywhere(rng, 0.0)


def random_anywhere(rng: np.random.Generator, low: float = -1.0) -> Configuration:
    """Slopes, two directions above the polar cosine `low` and a height distribution."""
    slopes = random_slopes(rng)
    wi, wo = random_direction(rng, low), random_direction(rng, low)
    heights = str(rng.choice(["uniform", "gaussian"]))
    return Configuration(slopes, wi, wo, heights=heights, drawn="random")


def hard_above() -> list[Configuration]:
    """Directions at the zenith, near it and grazing; roughness at its ends, and as unlike along
    the axes as can be drawn."""
    rough, smooth = ROUGHNESS[1], ROUGHNESS[0]
    zenith, near, grazing, across = (0.0, 0.0), (1e-4, 1.0), (GRAZING, 0.0), (GRAZING, math.pi / 2)
    return [
        Configuration(Beckmann(1.0, 1.0), (1.2, 0.0), (1.0, 2.0), heights="gaussian"),
        Configuration(Ggx(1.0, 1.0), (1.2, 0.0), (1.0, 2.0), heights="uniform"),
        Configuration(Beckmann(rough, smooth), grazing, across, heights="gaussian"),
        Configuration(Ggx(smooth, rough), across, grazing, heights="uniform"),
        Configuration(Ggx(rough, rough), (1.57, 0.3), zenith, heights="gaussian"),
        Configuration(Beckmann(smooth, smooth), near, (1.57, 0.3), heights="uniform"),
    ]


def hard_anywhere() -> list[Configuration]:
    """The same, and directions at, below and far below the horizon."""
    below = [math.pi / 2, 1.6, 2.2, 3.1, math.pi]
    return hard_above() + [
        Configuration(slopes, (theta, 0.4), (0.7, 2.0), heights=heights)
        for slopes, heights in ((Beckmann(0.7, 0.7), "gaussian"), (Ggx(1.5, 0.3), "uniform"))
        for theta in below
    ]
