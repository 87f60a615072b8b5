"""The tables of a run, as columns."""

import math

import numpy as np

from msbsdf_cli.results.directory import Table
from msbsdf_cli.results.run import FreePaths, Outcome
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.tally import (
    MOMENTS,
    PHI_BINS,
    SIDES,
    Estimate,
    lobe_axes,
    sequence_names,
)
from surfaces.facet import Array


def order_names(orders: int) -> list[str]:
    """`1`, `2`, ..., `K`, `>K`."""
    return [*map(str, range(1, orders + 1)), f">{orders}"]


def _columns(*names: str) -> dict[str, list[float | str]]:
    return {name: [] for name in names}


def _append(table: dict[str, list[float | str]], *row: float | str) -> None:
    for column, value in zip(table.values(), row, strict=True):
        column.append(value)


def _sides(scene: Scene) -> tuple[str, ...]:
    return SIDES if scene.material.transmits else SIDES[:1]


def _short(values: Array) -> list[float]:
    """The digits of a single-precision number, which halves the longest table."""
    return [float(f"{v:.9g}") for v in values]


ENERGY = ("theta_i_rad", "phi_i_rad", "order", "side", "energy", "stderr")


def energy(scene: Scene, outcome: Outcome) -> Table:
    """energy.csv of a producer."""
    rest = [
        {name: tally.estimate(name) for name in ("absorbed", "unresolved")}
        for tally in outcome.tallies
    ]
    return energy_table(scene, [tally.estimate("energy") for tally in outcome.tallies], rest)


def energy_table(scene: Scene, energies: list[Estimate], rest: list[dict[str, Estimate]]) -> Table:
    """energy.csv, from energies (order, side) and what else became of the light, for each
    incident angle."""
    table = _columns(*ENERGY)
    for theta, estimate, others in zip(scene.theta, energies, rest, strict=True):
        for row, order in enumerate(order_names(scene.orders)):
            for column, side in enumerate(_sides(scene)):
                value, stderr = estimate.value[row, column], estimate.stderr[row, column]
                _append(table, theta, scene.phi, order, side, float(value), float(stderr))
        for name, total in others.items():
            _append(table, theta, scene.phi, "all", name, float(total.value), float(total.stderr))
    return table


def moments(scene: Scene, outcome: Outcome) -> Table:
    """moments.csv"""
    names = [f"mean_{m}" for m in MOMENTS] + [f"stderr_{m}" for m in MOMENTS]
    table = _columns("theta_i_rad", "phi_i_rad", "order", "side", *names)
    for theta, tally in zip(scene.theta, outcome.tallies, strict=True):
        estimate = tally.estimate("moments")
        for row, order in enumerate(order_names(scene.orders)):
            for column, side in enumerate(_sides(scene)):
                values = estimate.value[row, column].tolist()
                stderrs = estimate.stderr[row, column].tolist()
                _append(table, theta, scene.phi, order, side, *values, *stderrs)
    return table


LOBE = (
    "theta_i_rad",
    "phi_i_rad",
    "order",
    "side",
    "theta_o_rad",
    "phi_o_rad",
    "solid_angle_sr",
    "density_per_sr",
    "stderr_per_sr",
)


def lobe(scene: Scene, outcome: Outcome) -> Table:
    """lobe.csv of a producer."""
    estimates = [tally.estimate("lobe") for tally in outcome.tallies]
    solid_angle = np.repeat(lobe_axes()[2], PHI_BINS)
    return lobe_table(
        scene,
        [e.value / solid_angle for e in estimates],
        [e.stderr / solid_angle for e in estimates],
    )


def lobe_table(scene: Scene, density: list[Array], stderr: list[Array]) -> Table:
    """lobe.csv, without empty bins, from arrays (order, side, bin) for each incident angle."""
    table = _columns(*LOBE)
    polar, azimuth, solid_angle = lobe_axes()
    theta_o, phi_o = (a.ravel() for a in np.meshgrid(polar, azimuth, indexing="ij"))
    solid = np.repeat(solid_angle, PHI_BINS)
    for i, theta in enumerate(scene.theta):
        for row, order in enumerate(order_names(scene.orders)):
            for column, side in enumerate(_sides(scene)):
                values = density[i][row, column]
                filled = np.flatnonzero(values)
                n = filled.size
                columns = (
                    [theta] * n,
                    [scene.phi] * n,
                    [order] * n,
                    [side] * n,
                    (theta_o if column == 0 else math.pi - theta_o)[filled].tolist(),
                    phi_o[filled].tolist(),
                    solid[filled].tolist(),
                    _short(values[filled]),
                    _short(stderr[i][row, column][filled]),
                )
                for name, cells in zip(table, columns, strict=True):
                    table[name].extend(cells)
    return table


def sequence(scene: Scene, outcome: Outcome) -> Table:
    """sequence.csv: histories that occurred."""
    table = _columns("theta_i_rad", "phi_i_rad", "sequence", "side", "energy", "stderr")
    for theta, tally in zip(scene.theta, outcome.tallies, strict=True):
        estimate = tally.estimate("sequence")
        for row, name in enumerate(sequence_names(scene.orders)):
            for column, side in enumerate(SIDES):
                value, stderr = estimate.value[row, column], estimate.stderr[row, column]
                if value > 0:
                    _append(table, theta, scene.phi, name, side, float(value), float(stderr))
    return table


def free_path(scene: Scene, free_paths: FreePaths) -> Table:
    """free_path.csv, without rows that fewer than two surfaces had points for."""
    table = _columns(
        "theta_r_rad",
        "phi_r_rad",
        "height_start",
        "height_low",
        "height_high",
        "probability",
        "stderr",
    )
    estimate = free_paths.estimate()
    low = [*free_paths.edges[:-1].tolist(), math.inf]
    high = [*free_paths.edges[1:].tolist(), math.inf]
    for i, theta in enumerate(free_paths.theta):
        for j, start in enumerate(free_paths.starts):
            if np.isnan(estimate.stderr[i, j]).any():
                continue
            values = estimate.value[i, j].tolist(), estimate.stderr[i, j].tolist()
            for row in zip(low, high, *values, strict=True):
                _append(table, theta, scene.phi, start, *row)
    return table


def all_tables(scene: Scene, outcome: Outcome) -> dict[str, Table]:
    """Every table of a run, by file name."""
    tables = {
        "energy.csv": energy(scene, outcome),
        "moments.csv": moments(scene, outcome),
        "lobe.csv": lobe(scene, outcome),
        "free_path.csv": free_path(scene, outcome.free_paths),
    }
    if scene.material.transmits:
        tables["sequence.csv"] = sequence(scene, outcome)
    return tables
