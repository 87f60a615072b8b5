"""How far a simulated and a modelled report lie apart, and how much of it noise explains."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import click
import numpy as np

from msbsdf_cli.report.directory import Table, read_csv, read_run
from msbsdf_cli.report.free_path import Rows, load_free_paths
from msbsdf_cli.report.lobes import Lobes, load_lobes
from msbsdf_cli.run.streams import stream
from msbsdf_cli.tally import SIDES, lobe_axes, merge_bins
from surfaces.facet import Array

SAME = ("material", "alpha", "theta", "phi", "orders")
"""Options in which two runs of one scene agree, beside those that matter for the material."""
SAME_FOR = {"conductor": ("metal", "eta_k"), "diffuse": ("albedo",), "dielectric": ("ior",)}


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
    """The difference over its standard error; for a distance, what it exceeds noise by."""
    noise: float
    """How large a difference noise alone makes."""
    own: float
    """How much of the difference is the model's own."""
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
    for name in ("slopes", *SAME, *SAME_FOR.get(a.get("material"), ())):
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
    rows = _energies(simulated, modelled)
    for i, theta in enumerate(ours.theta):
        for side in range(1 + ours.transmits):
            rows += _total_variations(ours, theirs, i, theta, side)
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
        rows.append(_signed("energy", key, a, a_stderr, b, b_stderr))
    return rows


def _signed(
    quantity: str,
    place: tuple[float, float, str, str],
    a: float,
    a_stderr: float,
    b: float,
    b_stderr: float,
) -> Row:
    """A difference; its square less the noise's is an unbiased square of the model's own."""
    noise, d = math.hypot(a_stderr, b_stderr), b - a
    z = d / noise if noise > 0 else 0.0
    own = math.copysign(math.sqrt(max(d * d - noise * noise, 0)), d)
    return Row(quantity, *place, a, a_stderr, b, b_stderr, d, z, noise, own)


def _total_variations(ours: Lobes, theirs: Lobes, i: int, theta: float, side: int) -> list[Row]:
    """Of each order and of all, over bins of 9 by 18 degrees: in finer ones, noise would drown the
    difference."""
    solid_angle = lobe_axes()[2][:, None]
    orders = {name: [k] for k, name in enumerate(ours.orders)}
    rows = []
    for name, part in (orders | {"all": list(range(len(orders)))}).items():
        sums = [
            merge_bins(x.density[i, part, side].sum(axis=0) * solid_angle) for x in (ours, theirs)
        ]
        squares = [
            merge_bins((x.stderr[i, part, side] ** 2).sum(axis=0) * solid_angle**2)
            for x in (ours, theirs)
        ]
        errors = [np.sqrt(square) for square in squares]
        place = (theta, ours.phi, name, SIDES[side])
        rows.append(_distance("total_variation", place, sums, errors))
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
        rows.append(_distance("free_path_ks", place, [mine[2], other[2]], [mine[3], other[3]]))
        escape = (float(x[k][-1]) for x in (mine, other) for k in (2, 3))
        rows.append(_signed("free_path_escape", place, *escape))
    return rows


NOISE_DRAWS = 200
"""Enough that the mean and spread of distances by noise are known to some percent."""


def _distance(
    quantity: str,
    place: tuple[float, float, str, str],
    histograms: list[Array],
    errors: list[Array],
) -> Row:
    """Total variation or Kolmogorov-Smirnov distance of two histograms, beside their sums, or the
    shares that escaped, which come last.

    Noise alone makes any two histograms differ. Differences of noise alone are drawn many times
    from the standard errors, taken as independent between bins, for the mean and spread of their
    distances.
    """
    rng = stream(0, "noise of distances")
    stderr = np.hypot(*errors)
    noise = stderr * rng.standard_normal((NOISE_DRAWS, *stderr.shape))
    measure = _total_variation if quantity == "total_variation" else _kolmogorov_smirnov
    found = float(measure((histograms[1] - histograms[0])[None])[0])
    by_noise = measure(noise)
    mean, spread = float(by_noise.mean()), float(by_noise.std(ddof=1))
    z = (found - mean) / spread if spread > 0 else 0.0
    if quantity == "total_variation":
        sums = [
            (float(h.sum()), float(np.sqrt((e**2).sum())))
            for h, e in zip(histograms, errors, strict=True)
        ]
    else:
        sums = [(float(h[-1]), float(e[-1])) for h, e in zip(histograms, errors, strict=True)]
    return Row(quantity, *place, *sums[0], *sums[1], found, z, mean, max(found - mean, 0.0))


def _total_variation(difference: Array) -> Array:
    return np.abs(difference).reshape(len(difference), -1).sum(axis=1) / 2


def _kolmogorov_smirnov(difference: Array) -> Array:
    return np.abs(np.cumsum(difference, axis=1)).max(axis=1)


def in_one_sentence(rows: list[Row]) -> str:
    """What a reader would want to know first."""
    energies = [r for r in rows if r.quantity == "energy" and r.order != "all"]
    lobes = [r for r in rows if r.quantity == "total_variation" and r.order == "all"]
    escapes = [r for r in rows if r.quantity == "free_path_escape"]
    energy, lobe = max(energies, key=_own), max(lobes, key=_own)
    text = (
        f"Beyond noise, {energies[0].method} misses the energy of a single order by at most "
        f"{abs(energy.own):.3g} (order {energy.order}, {energy.side}, theta {energy.theta:.3g}: "
        f"{energy.modelled:.4f} modelled, {energy.simulated:.4f} simulated), "
        f"sends at most {lobe.own:.3g} of the light elsewhere (theta {lobe.theta:.3g})"
    )
    if escapes:
        escape = max(escapes, key=_own)
        text += (
            f", and misses the share of free paths that escape by up to {abs(escape.own):.3g} "
            f"({escape.order}, theta_r {escape.theta:.3g})"
        )
    return text + "."


def _own(row: Row) -> float:
    return abs(row.own)
