"""Where the difference between a BSDF in use and a surface comes from, in three parts.

The fitted distribution is not the surface's: the Smith walk on it is held against the Smith walk
on the surface's own slopes. Heights are correlated, which Smith ignores: the walk on own slopes is
held against light traced on the surface. Light bounces more than once: the single scattering of the
fitted distribution is held against all its bounces.

A part is the share of the light that goes elsewhere, another end of light being that it does not
leave. Slopes of one surface are no more than a sample: what a part owes to that is known from
walks on the slopes of its pieces, and on what is fitted to these.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

import numpy as np

from msbsdf_cli.experiments.compare import Place, Row, distance, signed
from msbsdf_cli.experiments.own_surface import PIECES
from msbsdf_cli.experiments.walk import WalkJob, jobs, run_walks
from msbsdf_cli.model import Smith
from msbsdf_cli.results.lobes import Lobes, order_names
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import OF_SURFACE, Slopes, distribution
from msbsdf_cli.smith.slopes.surface import Surface
from msbsdf_cli.statistics.binning import merge_sides
from msbsdf_cli.statistics.distances import Distance, Histogram, total_variation
from msbsdf_cli.statistics.tally import SIDES, Tally
from surfaces.describe import Description
from surfaces.describe.fits import KINDS, MOST, Kind, fitted
from surfaces.facet import Array

PARTS = ("part_distribution", "part_correlation", "part_bounces")
"""Quantities of the three parts in agreement.csv."""

Models = dict[str, list[Slopes]]
"""By name, slopes of the whole surface and then of its pieces, in the same order."""


class Split(NamedTuple):
    """Light by order and merged bins of both sides, and that of independent pieces."""

    value: Array
    """(theta, order, bin)"""
    stderr: Array
    pieces: Array
    """(piece, theta, order, bin)"""
    paths: int
    """Rays or walks for each incident angle."""
    walks: bool
    """Whether they are walks, each independent of all others."""


@dataclass(frozen=True)
class Parts:
    """What `parts` found."""

    rows: list[Row]
    fitted: Slopes
    """The distribution that is judged."""
    least: tuple[Slopes, int | None] | None
    """The least model that is within the part of correlated heights, and its bounces, None for all
    of them; None where there is no such model."""

    def worst(self, quantity: str) -> Row:
        """The row of the incident angle at which most of the light goes elsewhere."""
        return max((r for r in self.rows if r.quantity == quantity), key=lambda r: r.own)


LEAST = 4
"""Facets along either side of a piece, to which three parameters are fitted."""


def models_of(slopes: Array, kinds: tuple[Kind, ...] = KINDS) -> Models:
    """The surface's own slopes (2, nx, ny), and distributions of `kinds` fitted to them.

    Raises ValueError where a piece of the surface has no slopes that anything is fitted to.
    """
    every = int(np.ceil(np.sqrt(slopes[0].size / MOST)))
    side = round(PIECES**0.5)
    if min(slopes.shape[1:]) < side * LEAST:
        raise ValueError(
            f"{slopes.shape[1]} x {slopes.shape[2]} facets are too few: to know how pieces of the "
            f"surface differ, at least {side * LEAST} are wanted along either side."
        )
    rows = np.array_split(slopes[:, ::every, ::every], side, axis=1)
    pieces = [piece for row in rows for piece in np.array_split(row, side, axis=2)]
    level = [piece - piece.mean(axis=(1, 2), keepdims=True) for piece in pieces]
    models: Models = {OF_SURFACE: [Surface.of(part) for part in (slopes, *level)]}
    for kind in kinds:
        models[kind.name.replace("_", "-")] = [of_fit(part, kind) for part in (slopes, *level)]
    return models


def best_fit(about: Description) -> str:
    """Name of the distribution of the least misfit; Student's t, which has one parameter more, only
    where its tail is neither Beckmann's nor GGX's by more than two standard errors."""
    gamma = about["student_t_gamma"]
    tail = 1 / (gamma.value - 1)
    alike = [k for k in KINDS if k.tail is not None]
    if all(abs(tail - (k.tail or 0)) > 2 * gamma.stderr * tail**2 for k in alike):
        alike = list(KINDS)
    best = min(alike, key=lambda kind: about[f"{kind.name}_misfit"].value)
    return best.name.replace("_", "-")


def of_fit(slopes: Array, kind: Kind) -> Slopes:
    """The distribution of a kind that fits best to slopes (2, nx, ny)."""
    fit, name = fitted(slopes, kind), kind.name.replace("_", "-")
    shape = {"gamma": 1 + 1 / fit.tail} if name == "student-t" else {}
    found: Slopes = distribution(name)(fit.alpha_x, fit.alpha_y, **shape)
    return found


def walks_on(
    scene: Scene,
    models: Models,
    samples: int,
    seed: int,
    workers: Workers,
    precision: str,
    max_order: int,
    quiet: bool,
) -> dict[str, Split]:
    """The Smith walk on all models: `samples` walks for each incident angle on those of the whole
    surface, and as many on those of all pieces together."""
    angles, each = len(scene.theta), -(-samples // PIECES)
    wi = [scene.wi(theta, np.dtype(precision).type) for theta in scene.theta]

    def work() -> Iterator[list[WalkJob]]:
        for number, slopes in enumerate(chain.from_iterable(models.values())):
            whole, model = number % (PIECES + 1) == 0, Smith(slopes, scene.material)
            walks, index = samples if whole else each, number * angles
            what = walks, scene.orders, seed, max_order
            mine = [job for i, w in enumerate(wi) for job in jobs(model, w, *what, index + i)]
            size = -(-len(mine) // BATCHES) if whole else len(mine)
            yield from (mine[at : at + size] for at in range(0, len(mine), size))

    total = len(models) * angles * (samples + each * PIECES)
    tallies: dict[int, Tally] = {}
    light: list[Array] = []
    with Progress("walk", total, "walks", quiet) as progress:
        for found in map_ordered(_run, work(), workers):
            for index in [k for k in tallies if k < min(found)]:
                light.append(_merged(tallies.pop(index)))
            for index, part in found.items():
                tallies.setdefault(index, Tally(scene.orders)).merge(part)
                progress.advance(part.rays)
    light += map(_merged, tallies.values())
    every = np.array(light).reshape(len(models), PIECES + 1, angles, *light[0].shape)
    return {
        name: Split(of[0, :, 0], of[0, :, 1], of[1:, :, 0], samples, walks=True)
        for name, of in zip(models, every, strict=True)
    }


BATCHES = 4
"""Of walks on the slopes of the whole surface, whose tables each batch makes anew: to hand these
from process to process would take longer."""


def _run(batch: list[WalkJob]) -> dict[int, Tally]:
    """Tallies of jobs on the same slopes by the jobs' indices."""
    tallies: dict[int, Tally] = {}
    for job in batch:
        index, part = run_walks(job)
        tallies.setdefault(index, Tally(job.orders)).merge(part)
    return tallies


def _merged(tally: Tally) -> Array:
    """Energies and their standard errors (2, order, bin)."""
    found = tally.estimate("lobe")
    value, square = (np.array([merge_sides(a) for a in b]) for b in (found.value, found.stderr**2))
    return np.stack([value, np.sqrt(square)])


def traced(lobes: Lobes, rays: int) -> Split:
    """Light that was traced on a surface, `rays` for each incident angle."""
    assert lobes.groups is not None
    value, square = (
        np.array([[merge_sides(order) for order in angle] for angle in a])
        for a in (lobes.bins.value, lobes.bins.stderr**2)
    )
    groups = lobes.groups.astype(float).swapaxes(0, 1)
    return Split(value, np.sqrt(square), groups.reshape(*groups.shape[:3], -1), rays, walks=False)


def parts(
    scene: Scene, surface: Split, walks: dict[str, Split], models: Models, name: str
) -> Parts:
    """The three parts for the distribution `name`, one of `models`.

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
        for label, bounces in _models(models, every):
            found = _between(walks[label], own, i, bounces)
            sums = [_energy(own, i, slice(None)), _energy(walks[label], i, slice(bounces))]
            at = theta, scene.phi, _words(bounces, every), "all"
            rows.append(distance("model", at, sums, found, label))
    return Parts(rows, models[name][0], _least(rows, models, every))


def _models(models: Models, every: int) -> list[tuple[str, int]]:
    """Names and bounces of models, the least first: those that cost less time, and of these those
    of fewer parameters."""
    return [(n, b) for b in range(1, every + 1) for n in models if n != OF_SURFACE]


def _words(bounces: int, every: int) -> str:
    return "all" if bounces == every else str(bounces)


def _least(rows: list[Row], models: Models, every: int) -> tuple[Slopes, int | None] | None:
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
            return models[name][0], None if bounces == every else bounces
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
