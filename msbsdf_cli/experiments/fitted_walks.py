"""The Smith walk on a surface's own slopes, on what is fitted to these, and on those of its pieces:
slopes of one surface are no more than a sample, and its pieces tell of what."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from msbsdf_cli.experiments.own_surface import PIECES
from msbsdf_cli.experiments.walk import WalkJob, jobs, run_walks
from msbsdf_cli.model import Smith
from msbsdf_cli.results.lobes import Lobes
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import OF_SURFACE, Slopes, distribution
from msbsdf_cli.smith.slopes.surface import Surface
from msbsdf_cli.statistics.binning import merge_sides
from msbsdf_cli.statistics.tally import Tally
from surfaces.describe import Description
from surfaces.describe.fits import KINDS, MOST, Kind, fitted
from surfaces.facet import Array

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


def kinds(gamma: float | None) -> tuple[Kind, ...]:
    """Distributions to fit, Student's t with its own `gamma` or one that is fitted too."""
    if gamma is None:
        return KINDS
    tail = 1 / (gamma - 1)
    return tuple(replace(k, tail=tail) if k.name == "student_t" else k for k in KINDS)


LEAST = 4
"""Facets along either side of a piece, to which three parameters are fitted."""


def models_of(slopes: Array, kinds: tuple[Kind, ...] = KINDS) -> Models:
    """The surface's own slopes (2, nx, ny), and distributions of `kinds` fitted to them.

    Raises ValueError where a piece of the surface has no slopes that anything is fitted to.
    """
    side = round(PIECES**0.5)
    if min(slopes.shape[1:]) < side * LEAST:
        raise ValueError(
            f"{slopes.shape[1]} x {slopes.shape[2]} facets are too few: to know how pieces of the "
            f"surface differ, at least {side * LEAST} are wanted along either side."
        )
    # No more are fitted to, pieces together, than on the whole, but enough on a narrow strip.
    every = int(np.ceil(np.sqrt(slopes[0].size / MOST)))
    every = min(every, min(slopes.shape[1:]) // (side * LEAST))
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
"""Of walks on the slopes of the whole surface, whose tables each process makes anew: more processes
than that would make them for little."""


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
