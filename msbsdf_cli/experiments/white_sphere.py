"""The white sphere: what a sphere looks like in constant white light, by any method.

What absorbs nothing and loses no energy looks like the light around it. Pixels are those of
`render`, each seen from its own direction in the frame of its own place; those that are mirror
images of each other look the same, and their mean is taken.
"""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.render.picture import Settings, check_shades, render
from msbsdf_cli.experiments.render.scenes.furnace import white_sphere
from msbsdf_cli.experiments.render.stage import Stage
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.run.executors import Workers
from msbsdf_cli.scene import Scene
from surfaces.facet import Array

PIXELS, SAMPLES = 64, 32
"""Of a sphere, each way, and paths for each of its pixels."""


@dataclass(frozen=True)
class Sphere:
    """Radiance (3, PIXELS, PIXELS) of a sphere and what is around it, 1 where that is seen."""

    method: str
    alpha: tuple[float, float]
    image: Array
    covered: Array
    """Share of each pixel that the sphere covers, (PIXELS, PIXELS)."""
    noise: float
    """Root mean square standard error of a pixel of the sphere, over the light around it."""
    table_error: float
    """As that of a `Picture`."""


def white_spheres(
    scene: Scene,
    alphas: tuple[tuple[float, float], ...],
    methods: tuple[str, ...],
    seed: int,
    workers: Workers,
    quiet: bool,
) -> tuple[list[Sphere], list[str]]:
    """A sphere of each method at each roughness, and sentences on those that there are none of."""
    spheres, refused = [], {}
    stage = white_sphere()
    covered = _coverage(stage)
    for number, alpha in enumerate(alphas):
        settings = Settings(PIXELS, PIXELS, SAMPLES, seed, "bsdf", number=number)
        of, shading = scene.of_roughness(alpha), []
        for name in methods:
            try:
                check_shades(name, of.slopes, of.material)
                shading.append(name)
            except UnsupportedError as refusal:
                refused[name] = f"no white sphere by {name}: {refusal}."
        made = render(stage, of.slopes, of.material, tuple(shading), settings, workers, quiet)
        for picture in made:
            image, variance = (_folded(a) for a in (picture.mean, picture.stderr**2))
            # The mean of four, of which an even number of pixels leaves none its own image.
            noise = np.sqrt(variance.mean(axis=0)[covered == 1].mean() / 4)
            table = picture.table_error
            spheres.append(Sphere(picture.method, alpha, image, covered, float(noise), table))
    return spheres, list(refused.values())


def _folded(image: Array) -> Array:
    """The mean of (3, rows, columns) over its mirror images from left to right and top to
    bottom."""
    image = (image + image[:, ::-1]) / 2
    return np.asarray((image + image[:, :, ::-1]) / 2)


def _coverage(stage: Stage) -> Array:
    """Of pixels, by 4 x 4 rays each."""
    fine = (np.arange(4 * PIXELS) + 0.5) / (4 * PIXELS)
    x, y = (a.ravel() for a in np.meshgrid(fine, fine))
    o = np.tile(np.array(stage.camera.eye)[:, None], x.size)
    met = stage.body.meet(o, stage.camera.rays(x, y)).triangle >= 0
    return np.asarray(met.reshape(PIXELS, 4, PIXELS, 4).mean(axis=(1, 3)))
