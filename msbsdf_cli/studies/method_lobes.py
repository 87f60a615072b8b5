"""Lobes of a method as a report, so that it can be held against a simulated one."""

from pathlib import Path
from typing import Any

import numpy as np

from msbsdf_cli.scene import Scene
from msbsdf_cli.studies.evaluating import evaluate
from msbsdf_cli.studies.recording import write_report
from msbsdf_cli.studies.tables import energy_table, lobe_table
from msbsdf_cli.tally import Estimate, lobe_axes
from surfaces.facet import Array

SAMPLES_SHARE = 1 / 100
"""Walks of a method for each ray of the simulation: every walk serves all the bins."""


def write_method_lobes(
    draft: Path, scene: Scene, methods: tuple[str, ...], options: dict[str, Any]
) -> dict[str, Path]:
    """Evaluate methods at the centres of the lobes' bins; a directory for each, by name, with
    energy.csv and lobe.csv."""
    wo, solid_angle = _bins(scene.facets().transmits)
    samples = max(round(options["samples"] * SAMPLES_SHARE), 32)
    arithmetic = options["seed"], options["threads"], options["precision"], options["quiet"]
    values = evaluate(scene, methods, wo, samples, *arithmetic, solid_angle)
    directories = {}
    for name in methods:
        directories[name] = draft / name
        directories[name].mkdir()
        mine = [v for v in values if v.method == name]
        energies = [Estimate(*v.energy[:, 0]) for v in mine if v.energy is not None]
        shape = (scene.orders + 1, 1 + scene.facets().transmits, -1)
        lobes = [[a[0, :-1].reshape(shape) for a in (v.value, v.stderr)] for v in mine]
        tables = {
            "energy.csv": energy_table(scene, energies, [{}] * len(mine)),
            "lobe.csv": lobe_table(scene, *map(list, zip(*lobes, strict=True))),
        }
        record = {"command": "evaluate", "options": options | {"method": [name]}}
        write_report(directories[name], record, tables)
    return directories


def _bins(transmits: bool) -> tuple[Array, Array]:
    """Directions (3, n) of bin centres and solid angles (n,): one hemisphere, then the other."""
    polar, azimuth, solid_angle = lobe_axes()
    theta, phi = (a.ravel() for a in np.meshgrid(polar, azimuth, indexing="ij"))
    w = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    solid = np.repeat(solid_angle, azimuth.size)
    if not transmits:
        return w, solid
    return np.hstack([w, w * np.array([[1], [1], [-1]])]), np.tile(solid, 2)
