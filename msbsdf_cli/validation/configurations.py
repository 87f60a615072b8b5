"""Configurations to measure identities in: drawn at random, and fixed hard ones."""

import math
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.scene import direction
from msbsdf_cli.smith.slopes import NAMES, Slopes, distribution
from surfaces.facet import Array
from surfaces.materials import NAMES as MATERIALS
from surfaces.materials import Conductor, Dielectric, Material, material

ROUGHNESS = (0.05, 2.0)
"""Least and largest roughness that is drawn, along either axis."""

IOR = Dielectric().ior

LOSSLESS = tuple(name for name in MATERIALS if not material(name)().absorbs)
"""Materials of which all light comes back, unless they are told otherwise."""

GRAZING = 1.5
"""Polar angle of the hard directions that graze the surface."""

Angles = tuple[float, float]
"""Polar angle and azimuth, in radians."""


@dataclass(frozen=True)
class Configuration:
    """Slopes, directions, facets: as far as an identity speaks of them."""

    slopes: str
    alpha: tuple[float, float]
    wi: Angles
    wo: Angles | None = None
    material: str = ""
    eta_k: tuple[float, float] | None = None
    method: str = ""
    heights: str = ""
    drawn: str = "fixed"
    """`fixed` or `random`."""

    def distribution(self) -> Slopes:
        """The distribution of slopes."""
        return distribution(self.slopes)(*self.alpha)

    def facets(self) -> Material:
        """The facets: lossless, unless they are of a metal; glass has the index `IOR`."""
        if self.eta_k is not None:
            return Conductor((self.eta_k,))
        facets: Material = material(self.material or "conductor")()
        return facets

    @property
    def i(self) -> Array:
        """The direction wi, (3, 1)."""
        return direction(*self.wi)[:, None]

    @property
    def o(self) -> Array:
        """The direction wo, (3, 1)."""
        assert self.wo is not None
        return direction(*self.wo)[:, None]


def random_slopes(rng: np.random.Generator) -> tuple[str, tuple[float, float]]:
    """A distribution and its roughness along either axis, uniform in the logarithm."""
    low, high = np.log(ROUGHNESS)
    alpha_x, alpha_y = np.exp(rng.uniform(low, high, 2))
    return str(rng.choice(NAMES)), (float(alpha_x), float(alpha_y))


def random_direction(rng: np.random.Generator, low: float = -1.0) -> Angles:
    """Uniform over the sphere, above the polar cosine `low`."""
    return math.acos(rng.uniform(low, 1)), float(rng.uniform(0, 2 * math.pi))


def random_above(rng: np.random.Generator) -> Configuration:
    """Slopes, two directions above the surface and a height distribution."""
    slopes, alpha = random_slopes(rng)
    wi, wo = random_direction(rng, 0.0), random_direction(rng, 0.0)
    heights = str(rng.choice(["uniform", "gaussian"]))
    return Configuration(slopes, alpha, wi, wo, heights=heights, drawn="random")


def random_anywhere(rng: np.random.Generator) -> Configuration:
    """Slopes, two directions anywhere on the sphere and a height distribution."""
    slopes, alpha = random_slopes(rng)
    wi, wo = random_direction(rng), random_direction(rng)
    heights = str(rng.choice(["uniform", "gaussian"]))
    return Configuration(slopes, alpha, wi, wo, heights=heights, drawn="random")


def hard_above() -> list[Configuration]:
    """Directions at the zenith, near it and grazing; roughness at its ends, and as unlike along
    the axes as can be drawn."""
    rough, smooth = ROUGHNESS[1], ROUGHNESS[0]
    zenith, near, grazing, across = (0.0, 0.0), (1e-4, 1.0), (GRAZING, 0.0), (GRAZING, math.pi / 2)
    return [
        Configuration("beckmann", (1.0, 1.0), (1.2, 0.0), (1.0, 2.0), heights="gaussian"),
        Configuration("ggx", (1.0, 1.0), (1.2, 0.0), (1.0, 2.0), heights="uniform"),
        Configuration("beckmann", (rough, smooth), grazing, across, heights="gaussian"),
        Configuration("ggx", (smooth, rough), across, grazing, heights="uniform"),
        Configuration("ggx", (rough, rough), (1.57, 0.3), zenith, heights="gaussian"),
        Configuration("beckmann", (smooth, smooth), near, (1.57, 0.3), heights="uniform"),
    ]


def hard_anywhere() -> list[Configuration]:
    """The same, and directions at, below and far below the horizon."""
    below = [math.pi / 2, 1.6, 2.2, 3.1, math.pi]
    return hard_above() + [
        Configuration(slopes, alpha, (theta, 0.4), (0.7, 2.0), heights=heights)
        for slopes, alpha, heights in (
            ("beckmann", (0.7, 0.7), "gaussian"),
            ("ggx", (1.5, 0.3), "uniform"),
        )
        for theta in below
    ]
