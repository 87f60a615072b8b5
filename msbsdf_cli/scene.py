"""A scene: facets, slopes, roughness and the light that comes in, as the options resolve it."""

import math
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.smith.slopes import Slopes, distribution
from surfaces.facet import Array
from surfaces.materials import GREEN, METALS, Conductor, Dielectric, Diffuse, Material


@dataclass(frozen=True)
class Scene:
    """What two runs must share to be compared."""

    material: str
    alpha: tuple[float, float]
    theta: tuple[float, ...]
    """Incident polar angles in radians."""
    phi: float
    """Incident azimuth in radians."""
    slopes: str = "beckmann"
    ior: float = 1.5
    eta_k: tuple[tuple[float, float], ...] = ()
    """Complex index of a conductor in each channel; none for a perfect mirror."""
    albedo: tuple[float, ...] = (1.0,)
    """Of diffuse facets, in each channel."""
    orders: int = 4
    shape: tuple[tuple[str, float], ...] = ()
    """Parameters of the slope distribution beyond roughness, by name."""

    def facets(self) -> Material:
        """The facets' material."""
        if self.material == "conductor":
            return Conductor(self.eta_k)
        if self.material == "diffuse":
            return Diffuse(self.albedo)
        if self.material == "dielectric":
            return Dielectric(self.ior)
        raise ValueError(
            f"{self.material!r} is not a material: one of conductor, diffuse, dielectric."
        )

    def distribution(self) -> Slopes:
        """The distribution of slopes."""
        return distribution(self.slopes)(*self.alpha, **dict(self.shape))

    def wi(self, theta: float, dtype: type = np.float64) -> Array:
        """The incident direction (3,) of polar angle `theta`."""
        return direction(theta, self.phi).astype(dtype)

    def slug(self) -> str:
        """The scene as a file name."""
        alpha = "-".join(f"{a:g}" for a in dict.fromkeys(self.alpha))
        slopes = "-".join([self.slopes, *(f"{value:g}" for _, value in self.shape)])
        return f"{self.material}-{slopes}-{alpha}"


def direction(theta: float, phi: float = 0.0) -> Array:
    """Unit vector (3,) of polar angle and azimuth in radians."""
    return np.array(
        [math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)]
    )


def metal_indices(
    metal: str | None, numbers: tuple[float, ...] | None, colours: bool
) -> tuple[tuple[float, float], ...]:
    """Complex indices of a metal by name, in three colours or at 549 nm, or of N,K,N,K,..."""
    if metal is not None:
        return METALS[metal] if colours else METALS[metal][GREEN : GREEN + 1]
    pairs = numbers or ()
    return tuple(zip(pairs[::2], pairs[1::2], strict=True))
