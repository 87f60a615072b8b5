"""Lobes of a method as a report, so that it can be held against a simulated one."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from msbsdf_cli.experiments.evaluate import evaluate
from msbsdf_cli.results.manifest import write_report
from msbsdf_cli.results.tables import energy_table, lobe_table
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.tally import PHI_BINS, Estimate, lobe_axes
from surfaces.facet import Array

MOST_PLACES = 16
"""At most so many places in a bin: as many as there are parts of the samples to take them."""

SAMPLES_SHARE = 1 / 100
"""Walks of a method for each ray of the simulation: every walk serves all the bins."""


def write_method_lobes(
    draft: Path, scene: Scene, methods: tuple[str, ...], options: dict[str, Any]
) -> dict[str, Path]:
    """Evaluate methods in the lobes' bins; a directory for each, by name, with energy.csv and
    lobe.csv."""
    wo, solid_angle = bins(scene.material.transmits, places(scene))
    samples = max(round(options["samples"] * SAMPLES_SHARE), 32)
    arithmetic = options["seed"], options["threads"], options["precision"], options["quiet"]
    values = evaluate(scene, methods, wo, samples, *arithmetic, solid_angle)
    directories = {}
    for name in methods:
        directories[name] = draft / name
        directories[name].mkdir()
        mine = [v for v in values if v.method == name]
        energies = [Estimate(*v.energy[:, 0]) for v in mine if v.energy is not None]
        shape = (scene.orders + 1, 1 + scene.material.transmits, -1)
        lobes = [[a[0, :-1].reshape(shape) for a in (v.value, v.stderr)] for v in mine]
        tables = {
            "energy.csv": energy_table(scene, energies, [{}] * len(mine)),
            "lobe.csv": lobe_table(scene, *map(list, zip(*lobes, strict=True))),
        }
        record = {"command": "evaluate", "options": options | {"method": [name]}}
        write_report(directories[name], record, tables)
    return directories


def places(scene: Scene) -> int:
    """In how many places of a bin to evaluate: a power of 2, so many that the steps of azimuth are
    below half a lobe's standard deviation, but from 2 to `MOST_PLACES`.

    A facet's slope has the standard deviation alpha / sqrt(2). The material's `bend` multiplies it,
    and an azimuth near the horizon takes it times cos(theta). Lobes of diffuse facets are wide.
    """
    material = scene.material
    if not material.specular:
        return 2
    width = material.bend * min(scene.alpha) * math.cos(max(scene.theta)) / math.sqrt(2)
    wanted = 2 * (2 * math.pi / PHI_BINS) / width
    return min(2 ** max(math.ceil(math.log2(wanted)), 1), MOST_PLACES)


def bins(transmits: bool, k: int) -> tuple[Array, Array]:
    """Directions (k, 3, n) in the bins, each row in the same place of all of them, and the bins'
    solid angles (n,): one hemisphere, then the other. Places are the first `k` of Sobol's points,
    even in solid angle."""
    polar, azimuth, solid_angle = lobe_axes()
    half = (polar[1] - polar[0]) / 2
    # Without scrambling each axis is at the lower ends of k equal parts.
    points = qmc.Sobol(2, scramble=False).random(k) + 0.5 / k
    w = np.empty((k, 3, polar.size, azimuth.size))
    for place, (u, v) in zip(w, points, strict=True):
        top, bottom = np.cos(polar - half), np.cos(polar + half)
        cos = top + u * (bottom - top)
        phi = azimuth + (v - 0.5) * (azimuth[1] - azimuth[0])
        sin = np.sqrt(1 - cos * cos)
        place[0] = np.multiply.outer(sin, np.cos(phi))
        place[1] = np.multiply.outer(sin, np.sin(phi))
        place[2] = cos[:, None]
    wo = w.reshape(k, 3, -1)
    solid = np.repeat(solid_angle, azimuth.size)
    if not transmits:
        return wo, solid
    return np.concatenate([wo, wo * np.array([[1], [1], [-1]])], axis=2), np.tile(solid, 2)
