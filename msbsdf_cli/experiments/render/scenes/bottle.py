"""Three bottles, turned, that light each other: figure 17 of [HHdD16]."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from msbsdf_cli.experiments.render.body import Body, together, turned
from msbsdf_cli.experiments.render.camera import Camera
from msbsdf_cli.experiments.render.scenes.sphere import STUDIO
from msbsdf_cli.experiments.render.stage import Stage

DEFAULTS = {"material": "conductor", "slopes": "ggx", "alpha": "0.5", "metal": "gold", "rgb": True}

SECTIONS, RINGS = 180, 200
PLACES = ((-0.92, 0.15), (0.0, -0.35), (0.9, 0.2))
HEIGHT = (0.0, 0.06, 0.2, 1.15, 1.5, 1.62, 2.15, 2.2)
RADIUS = (0.36, 0.4, 0.42, 0.42, 0.2, 0.14, 0.13, 0.15)
"""Of the wall, from the foot to the lip."""


def stage(texture: str) -> Stage:
    """The scene; only `plate` has textures."""
    bodies = [_bottle(centre) for centre in PLACES]
    return Stage(
        together(*bodies),
        Camera((0.0, -6.2, 2.0), (0.0, 0.0, 1.05), 0.6, 1.25),
        STUDIO,
        exposure=1.6,
    )


def _bottle(centre: tuple[float, float]) -> Body:
    height = np.linspace(HEIGHT[0], HEIGHT[-1], RINGS)
    wall = np.stack([PchipInterpolator(HEIGHT, RADIUS)(height), height], axis=1)
    foot, lip = [0.0, HEIGHT[0]], [0.0, HEIGHT[-1]]
    return turned(np.vstack([foot, wall, lip]), SECTIONS, centre)
