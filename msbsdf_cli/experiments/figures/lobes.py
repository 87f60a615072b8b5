"""Lobes on explicit surfaces and of models: one surface in detail, and an atlas of twelve."""

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

import numpy as np

from msbsdf_cli.experiments.compare import Row, agreement
from msbsdf_cli.experiments.figures.settings import Settings, Tables
from msbsdf_cli.experiments.method_lobes import method_lobes
from msbsdf_cli.experiments.realisations import simulate
from msbsdf_cli.experiments.resolution import plan
from msbsdf_cli.experiments.walks import walk
from msbsdf_cli.results.files import Table, columns, from_rows
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.lobes import Lobes, plane_of_incidence
from msbsdf_cli.results.tables import energy, lobe
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.heights import Gaussian
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.materials import Conductor, Dielectric, Diffuse, Material

MATERIALS: tuple[Material, ...] = (Diffuse(), Conductor(), Dielectric(1.5))
"""In the order of the atlas."""

ROUGHNESSES = ((0.25, 0.25), (0.5, 0.5), (1.0, 1.0), (1.0, 0.1))
THETAS = (0.0, 0.5, 1.0, 1.5)
ORDERS = 3

MODELS = ("position-free-uncorrelated", "position-free-correlated")
"""Those of the atlas beside the walk."""


def traced_and_walked(scene: Scene, settings: Settings) -> tuple[Lobes, Lobes]:
    """Light of a scene on surfaces, and of the walk."""
    accuracy, rays = settings.pick((0.01, 100_000), (0.002, 1_000_000))
    none = FreePaths((), (), Gaussian.edges)
    resolution = plan(scene, accuracy, None, None, None, None)
    around = settings.seed, settings.workers
    simulated = simulate(scene, rays, resolution, none, *around, 10_000, settings.quiet)
    walks = settings.pick(400_000, 4_000_000)
    walked = walk(scene, walks, none, "gaussian", *around, "float64", 10_000, settings.quiet)
    return simulated.lobes(), walked.lobes()


def heitz_15(settings: Settings) -> Tables:
    """Lobes of roughness 0.1, 1 at theta 1.5 of mirrors, diffuse facets and glass, on surfaces and
    of the walk, and their energies order by order."""
    parts: dict[str, list[Table]] = {"heitz_15": [], "heitz_15_energy": []}
    for number, material in enumerate((Conductor(), Diffuse(), Dielectric(1.5))):
        scene = Scene(material, Beckmann(0.1, 1.0), (1.5,), orders=ORDERS)
        for light in traced_and_walked(scene, settings.of_scene(number)):
            where = {"material": material.name, "source": light.label}
            parts["heitz_15"].append(_beside(where, lobe(light)))
            parts["heitz_15_energy"].append(_beside(where, energy(light)))
    return {name: _one_below_the_other(some) for name, some in parts.items()}


PLANE = (
    *("source", "theta_i_rad", "order", "side", "theta_o_rad", "density_per_sr", "stderr_per_sr"),
)
"""Columns of a page of the atlas; angles behind the side of the light are negative."""


def wang_4_15(settings: Settings) -> Tables:
    """A page for each surface: lobes in the plane of incidence, order by order, traced, of the walk
    and of both position-free models; and how far each model is from the surfaces."""
    pages: dict[str, Table] = {}
    apart = []
    for number, scene in atlas():
        mine = settings.of_scene(number)
        simulated, walked = traced_and_walked(scene, mine)
        models = [walked, *position_free(scene, mine)]
        rows = [row for lobes in (simulated, *models) for row in _plane_rows(lobes)]
        pages[f"wang_{number}"] = from_rows(PLANE, rows)
        surface = {"figure": number, "material": scene.material.name}
        surface |= dict(zip(("alpha_x", "alpha_y"), scene.alpha, strict=True))
        for model in models:
            found = [r for r in agreement(simulated, model) if model is walked or _energy(r)]
            apart.append(_beside(surface, columns(found, (f.name for f in fields(Row)))))
    return {"wang_4_15": _one_below_the_other(apart), **pages}


def _energy(row: Row) -> bool:
    """Whether a row is told well of any model. A walk of the position-free ones serves all the
    bins, whose noise is then one, which distances between lobes take for independent."""
    return row.quantity == "energy"


def position_free(scene: Scene, settings: Settings) -> list[Lobes]:
    """Lobes of both position-free models."""
    rays = settings.pick(60_000, 400_000)
    around = settings.seed, settings.workers, "float64", settings.quiet
    return method_lobes(scene, MODELS, rays, *around)


def atlas() -> Iterator[tuple[int, Scene]]:
    """The number of each figure, and its scene."""
    for i, material in enumerate(MATERIALS):
        for j, alpha in enumerate(ROUGHNESSES):
            scene = Scene(material, Beckmann(*alpha), THETAS, orders=ORDERS)
            yield 4 + len(ROUGHNESSES) * i + j, scene


def _plane_rows(lobes: Lobes) -> Iterator[tuple[Any, ...]]:
    parts = {name: slice(k, k + 1) for k, name in enumerate(lobes.names)} | {"all": slice(None)}
    for i, theta in enumerate(lobes.theta):
        for s, side in enumerate(lobes.sides):
            for name, part in parts.items():
                angle, value, error = plane_of_incidence(lobes, i, part, s)
                radians = np.radians(angle).tolist()
                for cells in zip(radians, value.tolist(), error.tolist(), strict=True):
                    yield (lobes.label, theta, name, side, *cells)


def _beside(where: dict[str, Any], table: Table) -> Table:
    """A table with what is the same in all of its rows in front."""
    n = len(next(iter(table.values())))
    return {name: [value] * n for name, value in where.items()} | dict(table)


def _one_below_the_other(tables: list[Table]) -> Table:
    return {name: [x for table in tables for x in table[name]] for name in tables[0]}
