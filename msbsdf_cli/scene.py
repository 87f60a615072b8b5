"""A scene: a rough surface and the light that comes in."""

import math
from dataclasses import dataclass, replace

import numpy as np

from msbsdf_cli.smith.slopes import Slopes, parameters
from surfaces.facet import Array
from surfaces.materials import Material


@dataclass(frozen=True)
class Scene:
    """What two runs must share to be compared."""

    material: Material
    slopes: Slopes
    theta: tuple[float, ...]
    """Incident polar angles in radians."""
    phi: float = 0.0
    """Incident azimuth in radians."""
    orders: int = 4

    @property
    def alpha(self) -> tuple[float, float]:
        """Roughness along x and y."""
        return self.slopes.alpha_x, self.slopes.alpha_y

    def of_roughness(self, alpha: tuple[float, float]) -> "Scene":
        """The same scene, smoother or rougher."""
        return replace(self, slopes=replace(self.slopes, alpha_x=alpha[0], alpha_y=alpha[1]))

    def wi(self, theta: float, dtype: type = np.float64) -> Array:
        """The incident direction (3,) of polar angle `theta`."""
        return direction(theta, self.phi).astype(dtype)

    def slug(self) -> str:
        """The scene as a file name."""
        name = self.slopes.name
        shape = (getattr(self.slopes, parameter) for parameter in parameters(name))
        alpha = dict.fromkeys(self.alpha)
        words = [self.material.name, name, *(f"{x:g}" for x in (*shape, *alpha))]
        return "-".join(words)


def direction(theta: float, phi: float = 0.0) -> Array:
    """Unit vector (3,) of polar angle and azimuth in radians."""
    return np.array(
        [math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)]
    )
