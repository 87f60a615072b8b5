"""The scenes of `render` as scenes to recommend for, and how far off their pictures are."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from msbsdf_cli.experiments.recommend.scene_surface import SceneFile, SceneSurface
from msbsdf_cli.experiments.recommend.toml_scene import surface_of
from msbsdf_cli.experiments.render.picture import Picture, Settings, luminance, render
from msbsdf_cli.experiments.render.scenes import defaults, stage
from msbsdf_cli.experiments.render.scenes.plate import LEAST
from msbsdf_cli.methods.registry import holds
from msbsdf_cli.run.executors import Workers
from surfaces.facet import Array

WHOLE, CHEAPER = "walk", ("single", "energy-compensated", "turquin")
"""The picture of all bounces, and those that are held against it."""

SURFACE = "material", "slopes", "metal"

SETTINGS = Settings(96, 64, 64)
GROUPS = 16
"""Of rows of pixels, whose scatter tells the error."""


@dataclass(frozen=True)
class PictureError:
    """A line of picture.csv."""

    surface: str
    method: str
    error: float
    """Root mean square difference of luminance over the root mean square, noise taken off; 0 where
    there is no more than noise."""
    error_bound: float
    """At most so large is the error, to two standard errors."""


def scene_of(name: str) -> SceneFile:
    """The one surface of a scene of `render`."""
    of_scene: dict[str, Any] = defaults(name)
    alpha = float(of_scene["alpha"])
    entries: dict[str, Any] = {k: v for k, v in of_scene.items() if k in SURFACE}
    textured = of_scene.get("texture", "none") == "roughness"
    entries |= {"name": name, "alpha": [LEAST * alpha, alpha] if textured else alpha}
    return SceneFile([surface_of(entries)])


def picture_errors(
    surface: SceneSurface, seed: int, workers: Workers, quiet: bool
) -> list[PictureError]:
    """How far off the picture of a scene is by the cheaper methods that hold for its surface."""
    slopes, texture = surface.slopes[-1], defaults(surface.name).get("texture", "none")
    of, material = stage(surface.name, texture), surface.material
    settings = replace(SETTINGS, seed=seed)
    methods = [name for name in CHEAPER if holds(name, slopes, material)]
    whole, *others = render(of, slopes, material, (WHOLE, *methods), settings, workers, quiet)
    return [_error(surface.name, whole, other) for other in others]


def _error(name: str, whole: Picture, other: Picture) -> PictureError:
    """Squares less what noise adds to them in the mean, and the standard error of the quotient by
    the jackknife over groups of rows."""
    apart = luminance(other.mean - whole.mean) ** 2 - sum(
        luminance(p.stderr) ** 2 for p in (whole, other)
    )
    power = luminance(whole.mean) ** 2 - luminance(whole.stderr) ** 2
    groups = np.array(
        [[a.sum() for a in pair] for pair in zip(*map(_rows, (apart, power)), strict=True)]
    )
    left_out = _quotient(groups.sum(axis=0) - groups)
    n, square = len(groups), float(_quotient(groups.sum(axis=0)))
    stderr = np.sqrt((n - 1) / n * ((left_out - left_out.mean()) ** 2).sum())
    ends = square, square + 2 * stderr
    return PictureError(name, other.method, *(float(np.sqrt(max(end, 0))) for end in ends))


def _rows(image: Array) -> list[Array]:
    """Rows dealt out to groups in turn: what is at the top of a picture is unlike its bottom."""
    return [image[k::GROUPS] for k in range(GROUPS)]


def _quotient(sums: Array) -> Array:
    return np.asarray(sums[..., 0] / sums[..., 1])
