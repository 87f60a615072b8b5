"""A scene to render: what is seen, from where, in which light, and what it is made of."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.render.body import Body
from msbsdf_cli.experiments.render.camera import Camera
from msbsdf_cli.experiments.render.lights import Lights
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material
from surfaces.materials.diffuse import TexturedDiffuse


@dataclass(frozen=True)
class Look:
    """What differs from point to point of a surface, (n,) or (channels, n)."""

    alpha_x: Array
    alpha_y: Array
    albedos: Array | None = None
    """Of diffuse facets; None: those of the material."""


Texture = Callable[[Array, Slopes], Look]
"""From points (3, n) and the slopes of the whole surface to what is there."""


@dataclass(frozen=True)
class Stage:
    """Everything but the surface's slopes and material."""

    body: Body
    camera: Camera
    lights: Lights
    texture: Texture | None = None
    """None: the same everywhere."""
    exposure: float = 1.0
    """Radiance that a display shows as white."""

    def lanes(self, slopes: Slopes, material: Material, point: Array) -> tuple[Slopes, Material]:
        """Slopes and material at points (3, n)."""
        if self.texture is None:
            return slopes, material
        look = self.texture(point, slopes)
        if look.albedos is not None:
            material = TexturedDiffuse(lanes=look.albedos)
        return slopes.of_lanes(look.alpha_x, look.alpha_y), material


def ramp(low: float, high: float, u: Array) -> Array:
    """From `low` to `high` as u (n,) goes from 0 to 1."""
    return low + (high - low) * np.clip(u, 0, 1)
