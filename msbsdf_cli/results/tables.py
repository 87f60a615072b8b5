"""The tables of a run, as columns."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from msbsdf_cli.results.files import Table, from_rows
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.results.run import Run
from msbsdf_cli.statistics.binning import PHI_BINS, lobe_axes
from msbsdf_cli.statistics.tally import MOMENTS, SIDES, sequence_names
from surfaces.facet import Array

PLACE = ("theta_i_rad", "phi_i_rad", "order", "side")


def _places(lobes: Lobes) -> Iterator[tuple[tuple[int, int, int], tuple[Any, ...]]]:
    """Each incident angle, order and side: its place in arrays, and what stands for it in rows."""
    for i, theta in enumerate(lobes.theta):
        for k, order in enumerate(lobes.names):
            for s, side in enumerate(lobes.sides):
                yield (i, k, s), (theta, lobes.phi, order, side)


def energy(lobes: Lobes) -> Table:
    """energy.csv"""
    rows = [
        (*words, float(lobes.energy.value[place]), float(lobes.energy.stderr[place]))
        for place, words in _places(lobes)
    ]
    for name, total in lobes.rest.items():
        for theta, value, stderr in zip(lobes.theta, total.value, total.stderr, strict=True):
            rows.append((theta, lobes.phi, "all", name, float(value), float(stderr)))
    return from_rows((*PLACE, "energy", "stderr"), rows)


def lobe(lobes: Lobes) -> Table:
    """lobe.csv, without empty bins, in the digits of single precision, which halve the table."""
    polar, azimuth, solid_angle = lobe_axes()
    theta_o, phi_o = (a.ravel() for a in np.meshgrid(polar, azimuth, indexing="ij"))
    solid = np.repeat(solid_angle, PHI_BINS)
    value, stderr = lobes.bins.value / solid, lobes.bins.stderr / solid
    table: dict[str, list[Any]] = {name: [] for name in LOBE}
    for place, words in _places(lobes):
        filled = np.flatnonzero(value[place])
        angle = math.pi - theta_o if place[-1] else theta_o
        columns = [[word] * filled.size for word in words]
        columns += [a[filled].tolist() for a in (angle, phi_o, solid)]
        columns += [_short(a[place][filled]) for a in (value, stderr)]
        for column, cells in zip(table.values(), columns, strict=True):
            column.extend(cells)
    return table


LOBE = (
    *PLACE,
    "theta_o_rad",
    "phi_o_rad",
    "solid_angle_sr",
    "density_per_sr",
    "stderr_per_sr",
)


def _short(values: Array) -> list[float]:
    return [float(f"{v:.9g}") for v in values]


def moments(run: Run, lobes: Lobes) -> Table:
    """moments.csv"""
    estimates = [tally.estimate("moments") for tally in run.tallies]
    rows = [
        (*words, *estimates[i].value[k, s].tolist(), *estimates[i].stderr[k, s].tolist())
        for (i, k, s), words in _places(lobes)
    ]
    return from_rows((*PLACE, *(f"{n}_{m}" for n in ("mean", "stderr") for m in MOMENTS)), rows)


def sequence(run: Run) -> Table:
    """sequence.csv: histories that occurred."""
    rows = []
    for theta, tally in zip(run.scene.theta, run.tallies, strict=True):
        estimate = tally.estimate("sequence")
        for k, name in enumerate(sequence_names(run.scene.orders)):
            for s, side in enumerate(SIDES):
                value, stderr = float(estimate.value[k, s]), float(estimate.stderr[k, s])
                if value > 0:
                    rows.append((theta, run.scene.phi, name, side, value, stderr))
    return from_rows(("theta_i_rad", "phi_i_rad", "sequence", "side", "energy", "stderr"), rows)


def free_path(run: Run) -> Table:
    """free_path.csv, without rows that fewer than two surfaces had points for."""
    paths = run.free_paths
    low = [*paths.edges[:-1].tolist(), math.inf]
    high = [*paths.edges[1:].tolist(), math.inf]
    rows = [
        (theta, run.scene.phi, start, *bin_)
        for (theta, start), found in paths.rows().items()
        for bin_ in zip(low, high, found.value.tolist(), found.stderr.tolist(), strict=True)
    ]
    return from_rows(FREE_PATH, rows)


FREE_PATH = (
    "theta_r_rad",
    "phi_r_rad",
    "height_start",
    "height_low",
    "height_high",
    "probability",
    "stderr",
)


def all_tables(run: Run, lobes: Lobes) -> dict[str, Table]:
    """Every table of a run, by file name."""
    tables = {
        "energy.csv": energy(lobes),
        "moments.csv": moments(run, lobes),
        "lobe.csv": lobe(lobes),
        "free_path.csv": free_path(run),
    }
    return tables | ({"sequence.csv": sequence(run)} if lobes.transmits else {})
