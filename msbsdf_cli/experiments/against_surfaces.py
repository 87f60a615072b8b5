"""What remembering a facet is worth: Smith's walk and those with
memory, held against one simulation.

`wrong_order` is the share of the light that a model puts into the wrong order or on the wrong side,
half the sum of absolute differences; `total_variation` that in bins of directions and
`free_path_ks` the distance between free paths; all as they would be without noise
(`statistics.distances`)."""

import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from msbsdf_cli.experiments.compare import Row as Difference
from msbsdf_cli.experiments.compare import agreement
from msbsdf_cli.experiments.walks import add_free_paths, walk
from msbsdf_cli.memory.next_facet import Memory
from msbsdf_cli.memory.remembered import MOST, Remembered
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.run import Run
from msbsdf_cli.statistics.distances import Histogram, total_variation
from surfaces.spectrum import Spectrum


@dataclass(frozen=True)
class Row:
    """One quantity of one incident angle, or of one direction and height of free paths."""

    quantity: str
    material: str
    alpha_x: float
    alpha_y: float
    theta_rad: float
    start: str
    """Where free paths start; of energies and lobes nothing."""
    smith: float
    memory: float
    memory_2: float
    stderr: float
    """Of each, from what the simulation does not know, which is common to all."""
    cpu_smith_s: float
    cpu_memory_s: float
    cpu_memory_2_s: float
    """Processor time of the walks of all angles, tables apart."""


class _Modelled(NamedTuple):
    differences: list[Difference]
    cpu_s: float


def rows(simulated: Run, spectrum: Spectrum, walks: int, seed: int) -> list[Row]:
    """All quantities of a simulation of surfaces of this spectrum, against as many walks of each
    model for each incident angle."""
    lobes = simulated.lobes()
    models = []
    remembered = [Remembered(spectrum, number) for number in range(1, MOST + 1)]
    for memory in (None, *remembered):
        if memory is not None:
            Memory.of(*memory)
        paths, none = simulated.free_paths.empty(), FreePaths((), (), np.array([0.0, 1.0]))
        started = time.process_time()
        how = none, "gaussian", seed, 1, "float64", 10_000, True, memory
        run = walk(simulated.scene, walks, *how)
        took = time.process_time() - started
        add_free_paths(simulated.scene, paths, "gaussian", walks, seed, memory)
        run.free_paths = paths
        models.append(_Modelled(agreement(lobes, run.lobes()), took))
    return [*_orders(simulated, models), *_distances(simulated, models)]


def _row(
    run: Run, models: list[_Modelled], place: tuple[str, float, str], found: list[float], e: float
) -> Row:
    quantity, theta, start = place
    scene = run.scene
    about = quantity, scene.material.name, *scene.alpha, theta, start
    return Row(*about, found[0], found[1], found[2], e, *(m.cpu_s for m in models))


def _orders(run: Run, models: list[_Modelled]) -> list[Row]:
    found = []
    for theta in run.scene.theta:
        mine = [
            [d for d in m.differences if d.quantity == "energy" and d.theta_i_rad == theta]
            for m in models
        ]
        wrong = [max(total_variation(*_histograms(each)).own, 0) for each in mine]
        # Differences sum to nothing, and errors of orders are of either sign.
        error = float(np.sqrt(sum(d.noise**2 for d in mine[1])) / 2)
        found.append(_row(run, models, ("wrong_order", theta, ""), wrong, error))
    return found


def _histograms(orders: list[Difference]) -> tuple[Histogram, Histogram]:
    """Energies of all orders and sides, modelled and simulated."""
    modelled = [(d.modelled, d.modelled_stderr) for d in orders]
    simulated = [(d.simulated, d.simulated_stderr) for d in orders]
    return Histogram(*np.array(modelled).T), Histogram(*np.array(simulated).T)


def _distances(run: Run, models: list[_Modelled]) -> list[Row]:
    found: dict[tuple[str, float, str], list[Difference]] = {}
    for m in models:
        for d in m.differences:
            if d.quantity == "free_path_ks":
                place = d.quantity, d.theta_i_rad, d.order.removeprefix("from ")
            elif d.quantity == "total_variation" and d.order == "all":
                # Sides are apart, and add up.
                place = d.quantity, d.theta_i_rad, ""
            else:
                continue
            found.setdefault(place, []).append(d)
    made = []
    for place, each in found.items():
        size = len(each) // len(models)
        parts = [each[start : start + size] for start in range(0, len(each), size)]
        own = [sum(d.own for d in part) for part in parts]
        error = float(np.sqrt(sum(d.own_stderr**2 for d in parts[1])))
        made.append(_row(run, models, place, own, error))
    return made
