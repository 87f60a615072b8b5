"""How many bounces a rough surface needs, whatever the scene: over roughness and angle, for each
material and slope distribution."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.recommend.candidates import ORDERS, cases
from msbsdf_cli.experiments.recommend.scene_file import SceneSurface
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.smith.slopes import distribution
from surfaces.materials import Conductor, Dielectric, Diffuse

ALPHAS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0)
THETAS_DEG = (0, 15, 30, 45, 60, 75, 85)
TOLERANCES = (0.1, 0.01, 0.001)
MATERIALS = Conductor(), Diffuse(), Dielectric(1.5)
"""Without absorption, where light bounces most."""
SLOPES = ("beckmann", "ggx")


@dataclass(frozen=True)
class Entry:
    """Bounces that keep the error of albedo and lobe within a tolerance."""

    material: str
    slopes: str
    alpha: float
    perceptual: float
    """The root of alpha, which many renderers call roughness."""
    theta_i_rad: float
    tolerance: float
    bounces: int
    """One more than the model tells apart, where none of these is enough."""
    error: float
    """What they leave."""
    error_uncertainty: float


def sheet(workers: Workers, quiet: bool) -> list[Entry]:
    """All entries, material by material."""
    theta = tuple(np.radians(THETAS_DEG).tolist())
    surfaces = [
        SceneSurface(material.name, material, (distribution(slopes)(alpha, alpha),), theta)
        for material in MATERIALS
        for slopes in SLOPES
        for alpha in ALPHAS
    ]
    found = []
    with Progress("sheet", len(surfaces), "surfaces", quiet) as progress:
        for some in map_ordered(entries, surfaces, workers):
            found += some
            progress.advance(1)
    return found


def entries(surface: SceneSurface) -> list[Entry]:
    """Those of a surface of one roughness."""
    (slopes,) = surface.slopes
    found = []
    for case in cases(surface):
        for tolerance in TOLERANCES:
            enough = np.flatnonzero(case.later[:ORDERS] + case.known <= tolerance)
            bounces = int(enough[0]) + 1 if enough.size else ORDERS + 1
            left = float(case.later[bounces - 1])
            what = surface.name, slopes.name, slopes.alpha_x, float(np.sqrt(slopes.alpha_x))
            found.append(Entry(*what, case.theta, tolerance, bounces, left, case.known))
    return found
