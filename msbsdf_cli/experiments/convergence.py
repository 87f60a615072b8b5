"""How far a simulated energy depends on the mesh, the period, the waves and the offset of rays.

Cells and offsets are compared on the same fields with the same rays, so that only their own effect
is left; periods and numbers of waves on independent surfaces. Numbers of waves are varied on small
surfaces, and so on many: it is each surface's few waves that differ, not its places.
"""

from dataclasses import dataclass, replace

import numpy as np

from msbsdf_cli.experiments.random_surfaces import Resolution, make_surface
from msbsdf_cli.results.files import Table, from_rows
from msbsdf_cli.results.lobes import order_names
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.tally import SIDES, Tally
from surfaces.facet import Array
from surfaces.streams import stream
from surfaces.tracing import Tracer


@dataclass(frozen=True)
class Steps:
    """What is varied, and on how many surfaces."""

    cells: tuple[float | None, ...] = (4, 8, 16, 32, 48)
    extents: tuple[int, ...] = (8, 16, 32)
    waves: tuple[int | None, ...] = (30, 100, 300, 1000, None)
    surfaces: int = 32
    """On which cells and offsets are varied; independent surfaces of something else are 4 times
    more, since nothing of their noise cancels, and more again where they are smaller."""
    hits: bool = False
    """Whether hit points in single precision are tried as well."""


STEPS = Steps()
"""Those of `simulate --convergence`."""

LIFTS = (1.0, 10.0, 100.0, 1000.0)
"""Offsets of secondary rays, over the one that is used."""
EXTENT, EXTENT_OF_WAVES, CELLS_ELSE = 16, 4, 8
"""Of the surfaces on which something else is varied."""
HITS = (32.0, 64.0)
"""Bits of the numbers that place the facets' planes, and so of hit points."""


@dataclass(frozen=True)
class Trial:
    """One surface, traced in one or several ways."""

    scene: Scene
    parameter: str
    values: tuple[float | None, ...]
    number: int
    resolution: Resolution
    rays: int
    seed: int


def convergence(
    scene: Scene,
    samples: int,
    seed: int,
    workers: Workers,
    quiet: bool,
    steps: Steps | None = None,
    autocorrelation: str = "gaussian",
    heights_of: str = "gaussian",
) -> Table:
    """convergence.csv: energies, and their differences from the last value of each parameter.

    `samples` rays for each incident angle and value are spread over `steps.surfaces` surfaces of 16
    correlation lengths, four times as many where values are compared on independent surfaces.
    """
    steps = steps or STEPS
    surfaces = steps.surfaces
    rays = max(samples // surfaces, 1)
    base = Resolution(CELLS_ELSE, EXTENT, 0, None, autocorrelation, heights_of)
    paired = {"cells": steps.cells, "lift": LIFTS[::-1]} | ({"hits": HITS} if steps.hits else {})
    trials = [
        Trial(scene, parameter, values, i, base, rays, seed)
        for parameter, values in paired.items()
        for i in range(surfaces)
    ]
    independent: list[tuple[str, int | None, Resolution]] = [
        ("extent", e, replace(base, extent=e)) for e in steps.extents
    ]
    independent += [
        ("waves", w, replace(base, extent=EXTENT_OF_WAVES, waves=w)) for w in steps.waves
    ]
    for parameter, number, resolution in independent:
        count = _independent(surfaces, resolution.extent)
        part = max(4 * samples // count, 1)
        trials += [
            Trial(scene, parameter, (number,), i, resolution, part, seed) for i in range(count)
        ]
    results: dict[tuple[str, float | None], list[Array]] = {}
    with Progress("convergence", len(trials), "surfaces", quiet) as progress:
        for trial, energies in zip(trials, map_ordered(_energies, trials, workers), strict=True):
            for value, energy in zip(trial.values, energies, strict=True):
                results.setdefault((trial.parameter, value), []).append(energy)
            progress.advance(1)
    return _table(scene, {key: np.array(list_) for key, list_ in results.items()})


def _independent(surfaces: int, extent: int) -> int:
    """How many independent surfaces: as many as have the same area, or, where that were more, 64
    for each of the paired ones."""
    return 4 * surfaces * min(EXTENT**2, 16 * extent**2) // extent**2


def _energies(trial: Trial) -> list[Array]:
    """Energies (theta, order, side) for each value of the parameter."""
    out = []
    for value in trial.values:
        resolution = trial.resolution
        if trial.parameter == "cells":
            resolution = replace(resolution, cells=int(value or 0))
        field = trial.parameter, trial.number, resolution.extent, resolution.waves or 0
        rng = stream(trial.seed, "convergence heightfield", *field)
        surface = make_surface(resolution, rng)
        if trial.parameter == "lift":
            surface.lift *= value or 0
        if trial.parameter == "hits" and value == HITS[0]:
            surface.planes = surface.planes.astype(np.float32)
        stretch = surface.stretch(*trial.scene.alpha, trial.scene.phi)
        tracer = Tracer(surface, stretch, trial.scene.material)
        energies = []
        for i, theta in enumerate(trial.scene.theta):
            rng = stream(trial.seed, "convergence rays", *field, i)
            tally = Tally(trial.scene.orders, independent=False)
            for light in tracer.trace(trial.scene.wi(theta), trial.rays, rng, 1000):
                tally.add(light)
            energies.append(tally.as_unit().estimate("energy").value)
        out.append(np.array(energies))
    return out


def _table(scene: Scene, results: dict[tuple[str, float | None], Array]) -> Table:
    rows = []
    finest = {parameter: energies for (parameter, _), energies in results.items()}
    for (parameter, value), energies in results.items():
        last = finest[parameter]
        mean, stderr = _mean(energies)
        if parameter in ("cells", "lift", "hits"):
            apart, apart_stderr = _mean(energies - last)
        else:
            reference, reference_stderr = _mean(last)
            apart = mean - reference
            apart_stderr = np.hypot(stderr, reference_stderr) * (energies is not last)
        for i, theta in enumerate(scene.theta):
            for j, order in enumerate(order_names(scene.orders)):
                for k, side in enumerate(SIDES[: 1 + scene.material.transmits]):
                    place = parameter, "all" if value is None else float(value), theta, order, side
                    figures = (float(a[i, j, k]) for a in (mean, stderr, apart, apart_stderr))
                    rows.append((*place, *figures))
    names = ("parameter", "value", "theta_i_rad", "order", "side", "energy", "stderr")
    return from_rows((*names, "difference", "difference_stderr"), rows)


def _mean(samples: Array) -> tuple[Array, Array]:
    return samples.mean(axis=0), samples.std(axis=0, ddof=1) / np.sqrt(len(samples))
