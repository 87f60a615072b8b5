"""How far modelled light lies from simulated light, and how much of it noise explains."""

import math
from dataclasses import dataclass, fields

import numpy as np

from msbsdf_cli.checks import kind_of
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.results.result import Result
from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, merge_bins
from msbsdf_cli.statistics.distances import (
    Distance,
    Histogram,
    kolmogorov_smirnov,
    total_variation,
)
from msbsdf_cli.statistics.tally import Estimate
from surfaces.facet import Array

SAME = ("material", "wi", "orders")
"""Settings in which two results of one scene agree, whatever they come from."""

Place = tuple[float, float, str, str]
"""Incident polar angle and azimuth, order and side; or direction and height of a free path."""


@dataclass(frozen=True)
class Row:
    """One line of agreement.csv."""

    quantity: str
    theta_i_rad: float
    phi_i_rad: float
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
    method: str


def compare(simulated: Result, modelled: Result) -> dict[str, Array]:
    """The rows of agreement.csv as arrays by column: energies, and distances between lobes.

    `difference` is modelled minus simulated, or the distance; `own` what it would be without
    noise, with its error bar `own_stderr`. Raises ValueError where the two are not of one scene, or
    the other way round.
    """
    for result in (simulated, modelled):
        kind_of(result, Result, "a result of simulate or walk")
    if (simulated.kind, modelled.kind) == ("walk", "simulate"):
        raise ValueError("the results are of walk and of simulate: what is simulated comes first.")
    for name in SAME:
        a, b = (r.settings.get(name) for r in (simulated, modelled))
        if a != b:
            raise ValueError(f"the results are of different scenes: {name} is {a} and {b}.")
    rows = agreement(simulated.lobes(), modelled.lobes())
    return {f.name: np.array([getattr(row, f.name) for row in rows]) for f in fields(Row)}


def agreement(simulated: Lobes, modelled: Lobes) -> list[Row]:
    """Every quantity that both know, side by side. Raises ValueError where the bins of free paths
    differ."""
    rows = _energies(simulated, modelled)
    for i in range(len(simulated.theta)):
        for side in range(len(simulated.sides)):
            rows += _total_variations(simulated, modelled, i, side)
    if simulated.free_paths is not None and modelled.free_paths is not None:
        paths = simulated.free_paths, modelled.free_paths
        rows += _free_paths(*paths, simulated.phi, modelled.label)
    return rows


def _energies(simulated: Lobes, modelled: Lobes) -> list[Row]:
    rows = []
    for i, theta in enumerate(simulated.theta):
        for s, side in enumerate(simulated.sides):
            for k, order in enumerate(simulated.names):
                pair = simulated.energy, modelled.energy
                place = theta, simulated.phi, order, side
                measured = _pair(*pair, (i, k, s))
                rows.append(signed("energy", place, *measured, modelled.label))
        for name in (name for name in simulated.rest if name in modelled.rest):
            pair = simulated.rest[name], modelled.rest[name]
            place = theta, simulated.phi, "all", name
            rows.append(signed("energy", place, *_pair(*pair, (i,)), modelled.label))
    return rows


def _pair(
    a: Estimate, b: Estimate, place: tuple[int, ...]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Value and standard error of one estimate, and of the other."""
    first, second = ((float(e.value[place]), float(e.stderr[place])) for e in (a, b))
    return first, second


def _total_variations(simulated: Lobes, modelled: Lobes, i: int, side: int) -> list[Row]:
    """Of each order and of all."""
    parts = {name: [k] for k, name in enumerate(simulated.names)}
    rows = []
    for name, part in (parts | {"all": list(range(simulated.orders + 1))}).items():
        pair = [_histogram(lobes, i, part, side) for lobes in (simulated, modelled)]
        groups = simulated.groups
        mine = None if groups is None else groups[i, :, part, side].sum(axis=0)
        totals = [(float(h.value.sum()), math.hypot(*h.stderr)) for h in pair]
        place = simulated.theta[i], simulated.phi, name, simulated.sides[side]
        found = total_variation(pair[1], pair[0], mine)
        rows.append(distance("total_variation", place, totals, found, modelled.label))
    return rows


def _histogram(lobes: Lobes, i: int, part: list[int], side: int) -> Histogram:
    """Energies of some orders in bins of 9 by 18 degrees: in finer ones, noise would drown the
    difference."""
    shape = THETA_BINS, PHI_BINS
    value, square = (
        merge_bins(array[i, part, side].sum(axis=0).reshape(shape)).ravel()
        for array in (lobes.bins.value, lobes.bins.stderr**2)
    )
    return Histogram(value, np.sqrt(square))


def _free_paths(simulated: FreePaths, modelled: FreePaths, phi: float, label: str) -> list[Row]:
    if not np.array_equal(simulated.edges, modelled.edges):
        raise ValueError("the free paths have different height bins: other versions made them.")
    theirs = modelled.rows()
    rows = []
    for key, mine in simulated.rows().items():
        if key not in theirs:
            continue
        place = key[0], phi, f"from {key[1]:g}", "free path"
        pair = [Histogram(e.value, e.stderr) for e in (mine, theirs[key])]
        # The last bin holds those that escaped.
        first, second = ((float(h.value[-1]), float(h.stderr[-1])) for h in pair)
        found = kolmogorov_smirnov(pair[1], pair[0])
        rows.append(distance("free_path_ks", place, [first, second], found, label))
        rows.append(signed("free_path_escape", place, first, second, label))
    return rows


def signed(
    quantity: str,
    place: Place,
    simulated: tuple[float, float],
    modelled: tuple[float, float],
    method: str,
) -> Row:
    """A difference of two values, each with its standard error, which noise does not bias: all of
    it is the model's own, as far as known."""
    noise, d = math.hypot(simulated[1], modelled[1]), modelled[0] - simulated[0]
    z = d / noise if noise > 0 else 0.0
    return Row(quantity, *place, *simulated, *modelled, d, z, noise, d, noise, method)


def distance(
    quantity: str, place: Place, totals: list[tuple[float, float]], d: Distance, method: str
) -> Row:
    """A distance, beside a total of either histogram with its standard error."""
    z = d.own / d.own_stderr if d.own_stderr > 0 else 0.0
    noise = d.noise, d.own, d.own_stderr
    return Row(quantity, *place, *totals[0], *totals[1], d.found, z, *noise, method)
