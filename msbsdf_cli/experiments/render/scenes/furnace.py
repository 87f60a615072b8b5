"""A sphere and a vase in constant white light: figure 16 of [HHdD16].

What absorbs nothing and loses no energy disappears. Glass does so as a closed body, inside which
light is thrown to and fro; the vase is hollow, and lights itself.
"""

import numpy as np

from msbsdf_cli.experiments.render.body import together, turned
from msbsdf_cli.experiments.render.camera import Camera
from msbsdf_cli.experiments.render.lights import Lights
from msbsdf_cli.experiments.render.stage import Stage

DEFAULTS = {"material": "conductor", "slopes": "ggx", "alpha": "1"}

PARALLELS, SECTIONS = 120, 240
WALL = 0.06
"""Thickness of the vase."""


def stage(texture: str) -> Stage:
    """The scene; only `plate` has textures."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, PARALLELS + 1)
    radius = np.cos(angle)
    radius[[0, -1]] = 0
    sphere = turned(np.stack([radius, np.sin(angle)], axis=1), SECTIONS, (-1.15, 0.0))
    vase = turned(_vase(), SECTIONS, (1.15, 0.0))
    camera = Camera((0.0, -6.5, 3.0), (0.0, 0.0, 0.0), 0.74, 2.0)
    return Stage(together(sphere, vase), camera, Lights())


def _vase() -> np.ndarray:
    """Up the outer wall, over the rim, and down the inner wall to the bottom."""
    height = np.linspace(-1, 1, PARALLELS)
    outer = 0.62 + 0.28 * np.sin(2.2 * height) * np.cos(0.9 * height)
    inner = height[::-1] * (1 - WALL / 2) + WALL / 2
    walls = np.vstack(
        [np.stack([outer, height], 1), np.stack([np.interp(inner, height, outer) - WALL, inner], 1)]
    )
    return np.vstack([[0.0, -1.0], walls, [0.0, inner[-1]]])
