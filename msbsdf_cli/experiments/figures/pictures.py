"""Pictures with and without the later bounces, of scenes like those of [HHdD16]."""

from dataclasses import dataclass
from functools import partial
from typing import Any

from msbsdf_cli.experiments.figures.settings import Settings, Tables
from msbsdf_cli.experiments.render.picture import Picture, render, table_of
from msbsdf_cli.experiments.render.picture import Settings as Size
from msbsdf_cli.experiments.render.scenes import stage
from msbsdf_cli.results.files import from_rows
from msbsdf_cli.smith.slopes import Ggx
from surfaces.materials import Conductor, Dielectric, Diffuse, Material

METHODS = ("single", "walk-low-variance")

GOLD = Conductor.named("gold", rgb=True)
RED = Diffuse((0.9, 0.5, 0.2))
"""Of Figure 19."""


@dataclass(frozen=True)
class Panel:
    """A surface in a scene."""

    what: str
    scene: str
    material: Material
    alpha: float
    texture: str = "none"


PANELS = {
    "heitz_1": (
        Panel("glass plate, roughness 0.01 to 1", "plate", Dielectric(1.5), 1, "roughness"),
    ),
    "heitz_16": (
        Panel("mirror facets, roughness 1", "furnace", Conductor(), 1),
        Panel("diffuse facets of albedo 1, roughness 1", "furnace", Diffuse((1.0,) * 3), 1),
        Panel("glass, roughness 1", "furnace", Dielectric(1.5), 1),
    ),
    "heitz_17": (
        Panel("gold, roughness 0.5", "bottle", GOLD, 0.5),
        Panel("gold, roughness 0.3", "bottle", GOLD, 0.3),
        Panel("diffuse facets, roughness 0.5", "bottle", RED, 0.5),
        Panel("glass, roughness 0.5", "bottle", Dielectric(1.5), 0.5),
    ),
    "heitz_18": (Panel("gold, roughness 0.3", "sphere", GOLD, 0.3),),
    "heitz_19": (
        *(Panel(f"diffuse facets, roughness {a:g}", "sphere", RED, a) for a in (0.1, 0.5, 1.0)),
        *(Panel(f"glass, roughness {a:g}", "sphere", Dielectric(1.5), a) for a in (0.05, 0.4, 1.0)),
    ),
    "heitz_20": (Panel("gold plate, roughness 0.01 to 1", "plate", GOLD, 1, "roughness"),),
}
"""Slopes are GGX, as in the paper."""

PIXELS = (
    *("panel", "method", "row", "column", "red", "green", "blue"),
    *("red_stderr", "green_stderr", "blue_stderr"),
)


def pictures(name: str, settings: Settings) -> Tables:
    """Linear radiance of each pixel, and figures of each picture."""
    width, samples = settings.pick((72, 24), (192, 256))
    pixels: list[tuple[str | float, ...]] = []
    of_all: dict[str, list[Any]] = {}
    for panel in PANELS[name]:
        of = stage(panel.scene, panel.texture)
        size = Size(width, round(width / of.camera.aspect), samples, settings.seed)
        surface = Ggx(panel.alpha, panel.alpha), panel.material
        made = render(of, *surface, METHODS, size, settings.workers, settings.quiet)
        for picture in made:
            pixels += _pixels(panel.what, picture)
        known: dict[str, Any] = {"panel": [panel.what] * len(made)}
        known |= {"exposure": [of.exposure] * len(made), **table_of(made)}
        for column, cells in known.items():
            of_all.setdefault(column, []).extend(cells)
    return {name: from_rows(PIXELS, pixels), f"{name}_mean": of_all}


def _pixels(panel: str, picture: Picture) -> list[tuple[str | float, ...]]:
    """In the digits of single precision."""
    width = picture.mean.shape[-1]
    both = zip(*(a.reshape(3, -1).T.tolist() for a in (picture.mean, picture.stderr)), strict=True)
    return [
        (panel, picture.method, *divmod(k, width), *(float(f"{x:.9g}") for x in (*mean, *stderr)))
        for k, (mean, stderr) in enumerate(both)
    ]


heitz_1, heitz_16, heitz_17, heitz_18, heitz_19, heitz_20 = (partial(pictures, n) for n in PANELS)
