"""Where the difference between a BSDF in use and a surface comes from, in three parts.

The fitted distribution is not the surface's: the Smith walk on it is held against the Smith walk
on the surface's own slopes. Heights are correlated, which Smith ignores: the walk on own slopes is
held against light traced on the surface. Light bounces more than once: the single scattering of the
fitted distribution is held against all its bounces.

A part is the share of the light that goes elsewhere, another end of light being that it does not
leave. Slopes of one surface are no more than a sample: what a part owes to that is known from
walks on the slopes of its pieces, and on what is fitted to these.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.compare import Place, Row, distance, signed
from msbsdf_cli.experiments.fitted_walks import Split
from msbsdf_cli.results.lobes import order_names
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import OF_SURFACE
from msbsdf_cli.statistics.distances import Distance, Histogram, total_variation
from msbsdf_cli.statistics.tally import SIDES
from surfaces.facet import Array

PARTS = ("part_distribution", "part_correlation", "part_bounces")
"""Quantities of the three parts in agreement.csv."""


@dataclass(frozen=True)
class Parts:
    """What `parts` found."""

    rows: list[Row]
    fitted: str
    """Name of the distribution that is judged."""
    least: tuple[str, int | None] | None
    """The least model that is within the part of correlated heights, and its bounces, None for all
    of them; None where there is no such model."""

    def worst(self, quantity: str) -> Row:
        """The row of the incident angle at which most of the light goes elsewhere."""
        return max((r for r in self.rows if r.quantity == quantity), key=lambda r: r.own)


def parts(scene: Scene, surface: Split, walks: dict[str, Split], name: str) -> Parts:
    """The three parts for the fitted distribution `name`; `walks` are those on each and on the
    surface's own slopes.

    Rows `whole` hold all its bounces against the surface, and rows `model` each fitted
    distribution, followed for so many bounces, against all bounces on the surface's own slopes.
    """
    own, fit, rows = walks[OF_SURFACE], walks[name], []
    every = scene.orders + 1
    for i, theta in enumerate(scene.theta):
        place = theta, scene.phi, "all", "all"
        for quantity, model, truth, bounces, label in (
            (PARTS[0], fit, own, every, name),
            (PARTS[1], own, surface, every, OF_SURFACE),
            (PARTS[2], fit, fit, 1, name),
            ("whole", fit, surface, every, name),
        ):
            found = _later(fit, i) if model is truth else _between(model, truth, i, bounces)
            sums = [_energy(truth, i, slice(None)), _energy(model, i, slice(bounces))]
            rows.append(distance(quantity, place, sums, found, label))
            rows += _energies(f"{quantity}_energy", scene, model, truth, i, bounces, label)
        for label, bounces in _models(walks, every):
            found = _between(walks[label], own, i, bounces)
            sums = [_energy(own, i, slice(None)), _energy(walks[label], i, slice(bounces))]
            at = theta, scene.phi, _words(bounces, every), "all"
            rows.append(distance("model", at, sums, found, label))
    return Parts(rows, name, _least(rows, walks, every))


def _models(models: Iterable[str], every: int) -> list[tuple[str, int]]:
    """Names and bounces of models, the least first: those that cost less time, and of these those
    of fewer parameters."""
    return [(n, b) for b in range(1, every + 1) for n in models if n != OF_SURFACE]


def _words(bounces: int, every: int) -> str:
    return "all" if bounces == every else str(bounces)


def _least(rows: list[Row], models: Iterable[str], every: int) -> tuple[str, int | None] | None:
    """The first model that leaves out, at every angle, no more than correlated heights cost, as
    far as two standard errors tell."""
    floor = [row for row in rows if row.quantity == PARTS[1]]
    for name, bounces in _models(models, every):
        key = "model", name, _words(bounces, every)
        mine = [row for row in rows if (row.quantity, row.method, row.order) == key]
        beyond = [
            row.own - least.own - 2 * np.hypot(row.own_stderr, least.own_stderr)
            for row, least in zip(mine, floor, strict=True)
        ]
        if max(beyond) <= 0:
            return name, None if bounces == every else bounces
    return None


def _between(model: Split, truth: Split, i: int, bounces: int) -> Distance:
    """How much of the light goes elsewhere in a model of so many bounces.

    Two walks differ by what the same piece of the surface makes of both of them.
    """
    (a, a_pieces), (b, b_pieces) = _ends(model, i, bounces), _ends(truth, i, truth.value.shape[1])
    if not truth.walks:
        return total_variation(a, b, b_pieces)
    d = a_pieces - b_pieces
    stderr = np.maximum(_scatter(d), np.hypot(a.stderr, b.stderr))
    of_both, none = Histogram(a.value - b.value, np.zeros_like(stderr)), np.zeros_like(stderr)
    return total_variation(of_both, Histogram(none, stderr), d.mean(axis=0) - d)


def _ends(split: Split, i: int, bounces: int) -> tuple[Histogram, Array]:
    """Bins where light leaves and, last, the light that does not; the same of all pieces."""
    value = _with_rest(split.value[i, :bounces])
    pieces = _with_rest(split.pieces[:, i, :bounces])
    stderr = np.sqrt((split.stderr[i, :bounces] ** 2).sum(axis=0))
    return Histogram(value, np.append(stderr, _noise(split, value[-1], pieces[:, -1]))), pieces


def _with_rest(light: Array) -> Array:
    """From (..., order, bin), all orders, and what is missing to 1."""
    bins = light.sum(axis=-2)
    return np.concatenate([bins, 1 - bins.sum(axis=-1, keepdims=True)], axis=-1)


def _noise(split: Split, value: float, pieces: Array) -> float:
    """Standard error of a share of the light; what no path met has that of one in all."""
    if not split.walks:
        return float(np.hypot(_scatter(pieces), 1 / split.paths))
    # Of weights from 0 to 1, those that are either scatter most.
    return float(np.sqrt(max(value * (1 - value), 1 / split.paths) / split.paths))


def _scatter(pieces: Array) -> Array:
    """Standard error of a mean over pieces (piece, ...)."""
    return np.asarray(pieces.std(axis=0, ddof=1) / np.sqrt(len(pieces)))


def _energy(split: Split, i: int, orders: slice, side: int | None = None) -> tuple[float, float]:
    """Energy of some orders on one side or both, and its standard error."""
    half = split.value.shape[-1] // 2
    bins = slice(None) if side is None else slice(side * half, (side + 1) * half)
    value = float(split.value[i, orders, bins].sum())
    return value, _noise(split, value, split.pieces[:, i, orders, bins].sum(axis=(1, 2)))


def _later(split: Split, i: int) -> Distance:
    """The light of later bounces, which single scattering leaves out: all of it by name."""
    value, noise = _energy(split, i, slice(1, None))
    left_out = split.pieces[:, i, 1:].sum(axis=(1, 2))
    stderr = max(noise, float(_scatter(left_out)))
    return Distance(value, stderr, value, stderr)


def _energies(
    quantity: str, scene: Scene, model: Split, truth: Split, i: int, bounces: int, label: str
) -> Iterator[Row]:
    """Order by order and side by side."""
    for k, order in enumerate(order_names(scene.orders)):
        for s, side in enumerate(SIDES[: 1 + scene.material.transmits]):
            place: Place = scene.theta[i], scene.phi, order, side
            mine, theirs = (_energy(of, i, slice(k, k + 1), s) for of in (truth, model))
            yield signed(quantity, place, mine, theirs if k < bounces else (0.0, 0.0), label)
