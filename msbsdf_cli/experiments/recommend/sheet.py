"""How many bounces a rough surface needs, whatever the scene: over roughness and angle, for each
material and slope distribution; where a cheaper method does, and where more is pointless."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from msbsdf_cli.experiments.recommend.apart import CONFIDENCE, Apart, Place
from msbsdf_cli.experiments.recommend.candidates import COMPENSATED, compensation_apart
from msbsdf_cli.experiments.recommend.cases import ORDERS, Case, cases
from msbsdf_cli.experiments.recommend.scene_surface import SceneSurface
from msbsdf_cli.experiments.recommend.surfaces import SLOPES as TRACED
from msbsdf_cli.experiments.recommend.surfaces import distance
from msbsdf_cli.methods.registry import holds
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import distribution
from surfaces.materials import Conductor, Dielectric, Diffuse, Material

ALPHAS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0)
THETAS_DEG = (0, 15, 30, 45, 60, 75, 85)
TOLERANCES = (0.1, 0.01, 0.001)
MATERIALS = Conductor(), Diffuse(), Dielectric(1.5)
"""Without absorption, where light bounces most."""
SLOPES = ("beckmann", "ggx")

WALKS = 200_000
"""From each angle, for methods that replace later bounces: their total variation is known to .3 %
of all light or better."""

TRACED_ALPHAS = (0.1, 0.3, 0.6, 1.0)
TRACED_THETAS_DEG = (0, 30, 60, 75, 85)
RAYS = 300_000
"""Where surfaces are traced, and rays from each angle; between these the distance of the model from
them is interpolated, over the logarithm of roughness."""


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
    error_bound: float
    """At most."""
    instead: str = ""
    """A method of one bounce that is within the tolerance where a single bounce is not."""
    smith_from_surfaces: float = math.nan
    """How far the model of all bounces itself is from traced surfaces, in the same terms; not a
    number where none were traced."""
    smith_from_surfaces_stderr: float = math.nan
    of_use: int | str = ""
    """Bounces whose error is no larger than that distance, where the tolerance is surely below it:
    more are pointless."""


@dataclass(frozen=True)
class Floor:
    """How far the Smith model of all bounces is from traced surfaces of a material."""

    value: RegularGridInterpolator
    stderr: RegularGridInterpolator

    @classmethod
    def of(cls, rows: list[list[Apart]]) -> "Floor":
        """From what was found at `TRACED_ALPHAS`, from `TRACED_THETAS_DEG`."""
        value = np.array([[a.error(0) for a in row] for row in rows])
        bound = np.array([[a.most(0) for a in row] for row in rows])
        axes = np.log(TRACED_ALPHAS), np.radians(TRACED_THETAS_DEG)
        how = {"bounds_error": False, "fill_value": math.nan}
        # Neighbours share their fields, and so their errors: interpolation makes them no smaller.
        stderr = (bound - value) / CONFIDENCE
        return cls(*(RegularGridInterpolator(axes, v, **how) for v in (value, stderr)))

    def at(self, place: Place) -> tuple[float, float]:
        """The distance and its standard error; not numbers beyond what was traced."""
        where = [[math.log(place.alpha[0]), place.theta]]
        return float(self.value(where)[0]), float(self.stderr(where)[0])


def sheet(workers: Workers, quiet: bool) -> list[Entry]:
    """All entries, material by material."""
    theta = tuple(np.radians(THETAS_DEG).tolist())
    traced = [(material, alpha) for material in MATERIALS for alpha in TRACED_ALPHAS]
    kinds = [(m, s, a) for m in MATERIALS for s in SLOPES for a in ALPHAS]
    rows: dict[str, list[list[Apart]]] = {}
    found = []
    with Progress("sheet", len(kinds) + len(traced), "surfaces", quiet) as progress:
        for (m, _), row in zip(traced, map_ordered(_traced, traced, workers), strict=True):
            rows.setdefault(m.name, []).append(row)
            progress.advance(1)
        floors = {(name, TRACED): Floor.of(mine) for name, mine in rows.items()}
        jobs = (
            (SceneSurface(m.name, m, (distribution(s)(a, a),), theta), floors.get((m.name, s)))
            for m, s, a in kinds
        )
        for some in map_ordered(_entries, jobs, workers):
            found += some
            progress.advance(1)
    return found


def _traced(where: tuple[Material, float]) -> list[Apart]:
    """How far the model is from surfaces of one roughness, from each angle."""
    material, alpha = where
    theta = tuple(np.radians(TRACED_THETAS_DEG).tolist())
    return distance(
        Scene(material, distribution(TRACED)(alpha, alpha), theta, 0.0, ORDERS), RAYS, 0
    )


def _entries(job: tuple[SceneSurface, Floor | None]) -> list[Entry]:
    return entries(*job)


def entries(surface: SceneSurface, floor: Floor | None = None) -> list[Entry]:
    """Those of a surface of one roughness."""
    (slopes,) = surface.slopes
    names = [name for name in COMPENSATED if holds(name, slopes, surface.material)]
    found = []
    for case in cases(surface):
        instead = compensation_apart(case, names, WALKS, 0) if names else {}
        far = floor.at(case.place) if floor else (math.nan, math.nan)
        found += [_entry(surface.name, case, instead, tolerance, far) for tolerance in TOLERANCES]
    return found


def _entry(
    name: str, case: Case, instead: dict[str, Apart], tolerance: float, far: tuple[float, float]
) -> Entry:
    slopes, bounces = case.scene.slopes, bounces_within(case, tolerance)
    left = float(case.later[bounces - 1])
    good = [method for method, apart in instead.items() if apart.most(0) <= tolerance]
    pointless = far[0] - CONFIDENCE * far[1] > tolerance
    return Entry(
        *(name, slopes.name, slopes.alpha_x, math.sqrt(slopes.alpha_x), case.place.theta),
        *(tolerance, bounces, left, left + float(case.known.max())),
        good[0] if good and bounces > 1 else "",
        *far,
        bounces_within(case, far[0]) if pointless else "",
    )


def bounces_within(case: Case, tolerance: float) -> int:
    """The fewest whose error is within the tolerance."""
    enough = np.flatnonzero(case.later[:ORDERS] + case.known.max() <= tolerance)
    return int(enough[0]) + 1 if enough.size else ORDERS + 1
