"""A single slab under the sun alone: the scene of figure 17 of [WJFYHY22 supp.]."""

import numpy as np

from msbsdf_cli.experiments.render.body import Body
from msbsdf_cli.experiments.render.camera import Camera
from msbsdf_cli.experiments.render.lights import Lamp, Lights
from msbsdf_cli.experiments.render.stage import Stage

DEFAULTS = {"material": "conductor", "slopes": "ggx", "alpha": "0.5"}

SUN = 0.7
"""Its polar angle in radians; the paper does not give its own."""


def stage(texture: str) -> Stage:
    """The scene; only `plate` has textures."""
    import trimesh

    mesh = trimesh.creation.box(extents=(4.0, 4.0, 0.1))
    side = np.abs(mesh.face_normals[:, 0]) > 0.5
    tangents = np.where(side[:, None], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
    sun = Lamp((0.0, float(np.sin(SUN)), float(np.cos(SUN))), 400.0, (60.0, 60.0, 60.0))
    dark = Lights((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (sun,))
    camera = Camera((0.0, -4.2, 3.6), (0.0, 0.0, 0.0), 0.7)
    return Stage(Body(mesh.vertices, mesh.faces, tangents), camera, dark, exposure=0.5)
