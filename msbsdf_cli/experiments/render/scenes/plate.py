"""A plate whose roughness goes from 0 to 1, as in figures 1 (glass) and 20 (gold) of [HHdD16].

Stripes of rising and of falling roughness stand side by side, so that what a model does with
roughness shows as a pattern: where energy is lost, rough parts are dark. Roughness is the square of
a ramp, which is even to the eye, and begins at a hundredth, since 0 is no rough surface.
"""

from functools import partial

import numpy as np

from msbsdf_cli.experiments.render.body import Body
from msbsdf_cli.experiments.render.camera import Camera
from msbsdf_cli.experiments.render.lights import Lamp, Lights
from msbsdf_cli.experiments.render.stage import Look, Stage, ramp
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array

DEFAULTS = {"material": "dielectric", "slopes": "ggx", "alpha": "1", "texture": "roughness"}

HALF = (1.5, 1.0, 0.04)
"""Of the plate's sides."""

LEAST = 0.01
"""Of the highest roughness, where a texture begins."""
STRIPES = 6
TONES = ((0.9, 0.2), (0.5, 0.6), (0.2, 0.9))
"""Red, green and blue albedo at both ends of a stripe."""


def stage(texture: str) -> Stage:
    """The scene with `texture`, or without one for any other name."""
    textures = {
        "roughness": partial(_look, anisotropic=False, coloured=False),
        "anisotropy": partial(_look, anisotropic=True, coloured=False),
        "albedo": partial(_look, anisotropic=False, coloured=True),
    }
    lamp = Lamp((0.0, 0.6, 0.8), 8.0, (2.2, 2.1, 2.0))
    return Stage(
        _box(),
        Camera((0.0, -3.3, 3.1), (0.0, -0.1, 0.0), 0.8),
        Lights((0.75, 0.8, 0.9), (0.5, 0.5, 0.5), (lamp,), squares=0.45),
        textures.get(texture),
        exposure=1.7,
    )


def _box() -> Body:
    import trimesh

    mesh = trimesh.creation.box(extents=2 * np.array(HALF))
    # Where a face has no part along x, the tangent goes along y.
    side = np.abs(mesh.face_normals[:, 0]) > 0.5
    tangents = np.where(side[:, None], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
    return Body(mesh.vertices, mesh.faces, tangents)


def _look(point: Array, slopes: Slopes, anisotropic: bool, coloured: bool) -> Look:
    along, across = (point[:2] / np.array(HALF[:2])[:, None] + 1) / 2
    falls = np.mod(np.floor(across * STRIPES), 2) == 1
    u = np.where(falls, 1 - along, along)
    if coloured:
        one = np.full_like(u, 1.0)
        albedos = np.stack([ramp(*ends, u) for ends in TONES])
        return Look(slopes.alpha_x * one, slopes.alpha_y * one, albedos)
    part = ramp(np.sqrt(LEAST), 1, u) ** 2
    # Of an anisotropic texture the other roughness stays at its highest, so that each stripe goes
    # from brushed to blasted.
    return Look(slopes.alpha_x * part, slopes.alpha_y * (np.ones_like(u) if anisotropic else part))
