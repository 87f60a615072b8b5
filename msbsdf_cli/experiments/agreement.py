"""How far a simulated and a modelled report lie apart, and how much of it noise explains."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np

from msbsdf_cli.cli.terminal import measured
from msbsdf_cli.plots.free_path import Rows, load_free_paths
from msbsdf_cli.plots.lobes import Lobes, load_groups, load_lobes
from msbsdf_cli.results.directory import Table, read_csv, read_run
from msbsdf_cli.statistics.distances import (
    Distance,
    Histogram,
    kolmogorov_smirnov,
    total_variation,
)
from msbsdf_cli.statistics.tally import SIDES, lobe_axes, merge_bins
from surfaces.facet import Array
from surfaces.materials import NAMES, material

SAME = ("material", "alpha", "theta", "phi", "orders")
"""Options in which two runs of one scene agree, beside those that matter for the material."""


@dataclass(frozen=True)
class Row:
    """One line of agreement.csv."""

    quantity: str
    theta: float
    phi: float
    order: str
    side: str
    simulated: float
    simulated_stderr: float
    modelled: float
    modelled_stderr: float
    difference: float
    """Modelled minus simulated, or the distance between them."""
    z: float
    """`own` over its standard error."""
    noise: float
    """How large a difference noise alone makes."""
    own: float
    """How much of the difference is the model's own: what it would be without noise."""
    own_stderr: float
    method: str = "walk"


def in_order(first: Path, second: Path) -> tuple[Path, Path]:
    """A simulated and a modelled report of one scene, in this order.

    Raises click.ClickException where they are not.
    """
    runs = {read_run(d)["command"]: d for d in (first, second)}
    if set(runs) != {"simulate", "walk"}:
        raise click.ClickException(
            f"one report of `simulate` and one of `walk` are wanted; {first} and {second} are of "
            f"{' and '.join(f'`{c}`' for c in runs)}."
        )
    simulated, modelled = runs["simulate"], runs["walk"]
    a, b = (read_run(d)["options"] for d in (simulated, modelled))
    own = material(a["material"]).option_names() if a.get("material") in NAMES else ()
    for name in ("slopes", *SAME, *own):
        if a.get(name) != b.get(name):
            raise click.ClickException(
                f"the reports are of different scenes: {name} is {a.get(name)} in {simulated} "
                f"and {b.get(name)} in {modelled}."
            )
    if b["heights"] != "gaussian":
        raise click.ClickException(
            f"the heights of {modelled} are {b['heights']}, those of a surface gaussian; "
            "make it again without --heights."
        )
    return simulated, modelled


def agreement(simulated: Path, modelled: Path, method: str = "walk") -> list[Row]:
    """Every quantity of two reports, side by side; without free paths where the model has none."""
    ours, theirs = load_lobes(simulated), load_lobes(modelled)
    groups = load_groups(simulated)
    rows = _energies(simulated, modelled)
    for i in range(len(ours.theta)):
        for side in range(1 + ours.transmits):
            mine = None if groups is None else groups[i, :, :, side]
            rows += _total_variations(ours, theirs, i, side, mine)
    if (modelled / "free_path.csv").exists():
        rows += _free_paths(load_free_paths(simulated), load_free_paths(modelled), ours.phi)
    return [replace(row, method=method) for row in rows]


def as_table(rows: list[Row]) -> Table:
    """agreement.csv"""
    names = {"theta": "theta_i_rad", "phi": "phi_i_rad"}
    return {names.get(key, key): [vars(row)[key] for row in rows] for key in vars(rows[0])}


def _energies(simulated: Path, modelled: Path) -> list[Row]:
    numbers = ("theta_i_rad", "phi_i_rad", "energy", "stderr")
    ours, theirs = (read_csv(d / "energy.csv", numbers) for d in (simulated, modelled))
    keys = [
        list(zip(t["theta_i_rad"], t["phi_i_rad"], t["order"], t["side"], strict=True))
        for t in (ours, theirs)
    ]
    values = dict(zip(keys[1], zip(theirs["energy"], theirs["stderr"], strict=True), strict=True))
    rows = []
    for key, a, a_stderr in zip(keys[0], ours["energy"], ours["stderr"], strict=True):
        if key not in values:
            continue  # Methods that evaluate do not say what was absorbed.
        b, b_stderr = values[key]
        rows.append(signed("energy", key, a, a_stderr, b, b_stderr))
    return rows


def signed(
    quantity: str,
    place: tuple[float, float, str, str],
    a: float,
    a_stderr: float,
    b: float,
    b_stderr: float,
) -> Row:
    """A difference, which noise does not bias: all of it is the model's own, as far as known."""
    noise, d = math.hypot(a_stderr, b_stderr), b - a
    z = d / noise if noise > 0 else 0.0
    return Row(quantity, *place, a, a_stderr, b, b_stderr, d, z, noise, d, noise)


def _total_variations(
    ours: Lobes, theirs: Lobes, i: int, side: int, groups: Array | None
) -> list[Row]:
    """Of each order and of all, over bins of 9 by 18 degrees: in finer ones, noise would drown the
    difference. `groups` (group, order, bin) are lobes of groups of surfaces."""
    solid_angle = lobe_axes()[2][:, None]
    orders = {name: [k] for k, name in enumerate(ours.orders)}
    rows = []
    for name, part in (orders | {"all": list(range(len(orders)))}).items():
        simulated, modelled = (
            Histogram(
                merge_bins(x.density[i, part, side].sum(axis=0) * solid_angle).ravel(),
                np.sqrt(
                    merge_bins((x.stderr[i, part, side] ** 2).sum(axis=0) * solid_angle**2)
                ).ravel(),
            )
            for x in (ours, theirs)
        )
        place = (ours.theta[i], ours.phi, name, SIDES[side])
        totals = [
            (float(h.value.sum()), float(np.sqrt((h.stderr**2).sum())))
            for h in (simulated, modelled)
        ]
        mine = None if groups is None else groups[:, part].sum(axis=1)
        d = total_variation(modelled, simulated, mine)
        rows.append(distance("total_variation", place, totals, d))
    return rows


def _free_paths(ours: Rows, theirs: Rows, phi: float) -> list[Row]:
    rows = []
    for key in [key for key in ours if key in theirs]:
        mine, other = ours[key], theirs[key]
        if mine.shape != other.shape or not np.array_equal(mine[:2], other[:2]):
            raise click.ClickException(
                "the free paths of the reports have different height bins; make them again "
                "with the same version."
            )
        place = (key[0], phi, f"from {key[1]:g}", "free path")
        simulated, modelled = Histogram(*mine[2:]), Histogram(*other[2:])
        # The last bin holds those that escaped.
        escaped = [(float(h.value[-1]), float(h.stderr[-1])) for h in (simulated, modelled)]
        d = kolmogorov_smirnov(modelled, simulated)
        rows.append(distance("free_path_ks", place, escaped, d))
        rows.append(signed("free_path_escape", place, *escaped[0], *escaped[1]))
    return rows


def distance(
    quantity: str,
    place: tuple[float, float, str, str],
    totals: list[tuple[float, float]],
    d: Distance,
) -> Row:
    """A distance, beside a total of either histogram with its standard error."""
    z = d.own / d.own_stderr if d.own_stderr > 0 else 0.0
    return Row(quantity, *place, *totals[0], *totals[1], d.found, z, d.noise, d.own, d.own_stderr)


def in_one_sentence(rows: list[Row]) -> str:
    """What a reader would want to know first."""
    energies = [r for r in rows if r.quantity == "energy" and r.order != "all"]
    lobes = [r for r in rows if r.quantity == "total_variation" and r.order == "all"]
    escapes = [r for r in rows if r.quantity == "free_path_escape"]
    energy, lobe = max(energies, key=_own), max(lobes, key=_own)
    text = (
        f"Beyond noise, {energies[0].method} misses the energy of a single order by at most "
        f"{_size(energy)} (order {energy.order}, {energy.side}, theta {energy.theta:.3g}: "
        f"{energy.modelled:.4f} modelled, {energy.simulated:.4f} simulated), "
        f"sends at most {_size(lobe)} of the light elsewhere (theta {lobe.theta:.3g})"
    )
    if escapes:
        escape = max(escapes, key=_own)
        text += (
            f", and misses the share of free paths that escape by up to {_size(escape)} "
            f"({escape.order}, theta_r {escape.theta:.3g})"
        )
    return text + "."


def _own(row: Row) -> float:
    return abs(row.own)


def _size(row: Row) -> str:
    return measured(abs(row.own), row.own_stderr)
