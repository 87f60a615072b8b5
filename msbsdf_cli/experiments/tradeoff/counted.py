"""Rows of the walk that remembers the heights which rays pass (`walk --memory 2`).

A mirror's facet that such heights fix has no density, so that no method asks it for a direction:
its light is counted in bins, as that of surfaces is, and its error is against these.
"""

import time
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.tradeoff.rows import Row, costs, place, with_stderr
from msbsdf_cli.experiments.tradeoff.surface_reference import (
    Distance,
    SurfaceReference,
    distance,
    grouped_noise,
)
from msbsdf_cli.experiments.walk import WalkJob, run_walks
from msbsdf_cli.memory.remembered import Remembered
from msbsdf_cli.model import Smith
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.binning import merge_sides, merged_solid_angle
from msbsdf_cli.statistics.repetitions import root
from surfaces.facet import Array
from surfaces.spectrum import spectrum

NAME, MODEL = "walk-memory-2", "memory-2"

PARTS, WALKS = 16, 8192
"""Independent parts of the light, and walks of each."""

MAX_ORDER = 10_000


@dataclass(frozen=True)
class Counted:
    """Light counted in merged bins."""

    units: Array
    """Energy (parts, angles, bins)."""
    seconds: Array
    """Of each part, (parts, angles)."""
    setup_s: float
    """Of the tables, made for nobody else before."""


def count(scene: Scene, autocorrelation: str, seed: int) -> Counted:
    """Walk in this process, as what is timed does."""
    remembered = Remembered(spectrum(autocorrelation), 2)
    setup_s = _setup_s(remembered)
    model, units, seconds = Smith(scene.slopes, scene.material), [], []
    for part in range(PARTS):
        for i, theta in enumerate(scene.theta):
            work = scene.wi(theta), scene.orders, WALKS, seed, i, part, MAX_ORDER, remembered
            started = time.perf_counter()
            tally = run_walks(WalkJob(model, *work))[1]
            seconds.append(time.perf_counter() - started)
            units.append(merge_sides(tally.estimate("lobe").value.sum(axis=0)))
    shape = PARTS, len(scene.theta)
    return Counted(np.reshape(units, (*shape, -1)), np.reshape(seconds, shape), setup_s)


def _setup_s(remembered: Remembered) -> float:
    from msbsdf_cli.memory.correlation import correlation
    from msbsdf_cli.memory.entry import entry
    from msbsdf_cli.memory.escape import escape
    from msbsdf_cli.memory.next_facet import Memory
    from msbsdf_cli.memory.profile import profile
    from msbsdf_cli.memory.way_in import way_in

    for table in (correlation, entry, escape, profile, way_in):
        # Others may have made some of them already.
        table.cache_clear()
    started = time.perf_counter()
    Memory.of(*remembered)
    return time.perf_counter() - started


def counted_rows(
    scene: Scene, counted: Counted, surfaces: SurfaceReference
) -> tuple[list[Row], list[Distance]]:
    """Rows of ever more walks, and how far the model is from the surfaces, angle by angle."""
    rows, found = [], []
    for i, theta in enumerate(scene.theta):
        units = counted.units[:, i]
        apart = root(*distance(surfaces.units[:, i], units, merged_solid_angle()))
        found.append(Distance(theta, MODEL, *apart))
        low, middle, high = np.percentile(counted.seconds[:, i], (25, 50, 75)).tolist()
        for size, noise, stderr in grouped_noise(units):
            total = float(np.hypot(noise, apart[0]))
            error = float(np.hypot(noise * stderr, apart[0] * apart[1])) / max(total, 1e-300)
            rows.append(
                Row(
                    method=NAME,
                    samples=size * WALKS,
                    reference="surfaces",
                    model=MODEL,
                    **place(scene, theta),
                    **with_stderr(relative_rmse=(total, error), bias=apart, noise=(noise, stderr)),
                    **costs(total**2, (size * low, size * middle, size * high), counted.setup_s),
                )
            )
    return rows, found
