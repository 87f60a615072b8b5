"""A sphere in a studio: figure 18 (gold) and figure 19 (diffuse, glass) of [HHdD16]."""

import numpy as np

from msbsdf_cli.experiments.render.body import turned
from msbsdf_cli.experiments.render.camera import Camera
from msbsdf_cli.experiments.render.lights import Lamp, Lights
from msbsdf_cli.experiments.render.stage import Stage

DEFAULTS = {"material": "conductor", "slopes": "ggx", "alpha": "0.5", "metal": "gold", "rgb": True}

PARALLELS, SECTIONS = 180, 360
"""A triangle is one degree wide."""

STUDIO = Lights(
    (0.45, 0.5, 0.6),
    (0.2, 0.19, 0.18),
    (
        Lamp((-0.48, -0.64, 0.6), 12.0, (3.4, 3.2, 2.9)),
        Lamp((0.8, 0.36, 0.48), 30.0, (2.2, 2.4, 2.8)),
    ),
)
"""A warm key light on the left, a cooler one on the right from behind."""


def stage(texture: str) -> Stage:
    """The scene; only `plate` has textures."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, PARALLELS + 1)
    radius = np.cos(angle)
    radius[[0, -1]] = 0
    body = turned(np.stack([radius, np.sin(angle)], axis=1), SECTIONS)
    return Stage(body, Camera((0.0, -5.0, 1.2), (0.0, 0.0, 0.0), 0.55, 1.2), STUDIO, exposure=1.6)
