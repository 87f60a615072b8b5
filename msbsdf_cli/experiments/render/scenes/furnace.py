"""A sphere and a vase in constant white light: figure 16 of [HHdD16]; and a sphere alone.

What absorbs nothing and loses no energy disappears. Glass does so as a closed body, inside which
light is thrown to and fro; the vase is hollow, and lights itself.
"""

import numpy as np

from msbsdf_cli.experiments.render.body import Body, together, turned
from msbsdf_cli.experiments.render.camera import Camera
from msbsdf_cli.experiments.render.lights import Lights
from msbsdf_cli.experiments.render.stage import Stage

DEFAULTS = {"material": "conductor", "slopes": "ggx", "alpha": "1"}

PARALLELS, SECTIONS = 120, 240
SPHERE_IN_VIEW = 1.1
"""Half the width of the picture of a sphere alone, in its radii, or nearly."""
WALL = 0.06
"""Thickness of the vase."""


def stage(texture: str) -> Stage:
    """The scene; only `plate` has textures."""
    vase = turned(_vase(), SECTIONS, (1.15, 0.0))
    camera = Camera((0.0, -6.5, 3.0), (0.0, 0.0, 0.0), 0.74, 2.0)
    return Stage(together(_sphere((-1.15, 0.0)), vase), camera, Lights())


def white_sphere() -> Stage:
    """The sphere alone from its own height, the x axis of the roughness horizontal."""
    away = 8.0
    view = 2 * np.arcsin(SPHERE_IN_VIEW / away)
    return Stage(_sphere(), Camera((0.0, -away, 0.0), (0.0, 0.0, 0.0), float(view), 1.0), Lights())


def _sphere(centre: tuple[float, float] = (0.0, 0.0)) -> Body:
    angle = np.linspace(-np.pi / 2, np.pi / 2, PARALLELS + 1)
    radius = np.cos(angle)
    radius[[0, -1]] = 0
    return turned(np.stack([radius, np.sin(angle)], axis=1), SECTIONS, centre)


def _vase() -> np.ndarray:
    """Up the outer wall, over the rim, and down the inner wall to the bottom."""
    height = np.linspace(-1, 1, PARALLELS)
    outer = 0.62 + 0.28 * np.sin(2.2 * height) * np.cos(0.9 * height)
    inner = height[::-1] * (1 - WALL / 2) + WALL / 2
    walls = np.vstack(
        [np.stack([outer, height], 1), np.stack([np.interp(inner, height, outer) - WALL, inner], 1)]
    )
    return np.vstack([[0.0, -1.0], walls, [0.0, inner[-1]]])
