"""Light on one surface that is given, and not on many that are random.

There is no other realisation of it: error bars come from the scatter of its own pieces, and say how
far another piece of the same kind of surface may be off.
"""

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from msbsdf_cli.experiments.realisations import FREE_PATHS_OF_RAYS, LobeGroups
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.run import Run
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene, direction
from msbsdf_cli.statistics.tally import Tally
from surfaces.describe.correlation import correlation_lengths
from surfaces.facet import Array
from surfaces.field import HeightField
from surfaces.free_path import FreePathTracer
from surfaces.materials import Material
from surfaces.streams import stream
from surfaces.tracing import Tracer
from surfaces.views import Views

PIECES = 16
"""Pieces of the surface, squares of a quarter of its sides, whose scatter tells the error: known
to a fifth. They are independent as far as a quarter of a side is long against the bumps."""

LARGE = 1 << 21
"""Cells of a mesh of the whole, above which windows are meshed instead: a gigabyte."""

WINDOW = 1024
"""Cells along the sides of a window, at most."""

AROUND = 16
"""Correlation lengths around a piece, at least: about as far as light at 1.5 radians comes."""


class Part(NamedTuple):
    """A piece of a surface: what is meshed, and where on that rays start."""

    field: HeightField
    place: tuple[int, int]


def number_of_pieces(field: HeightField) -> tuple[int, bool]:
    """Into how many pieces a surface is cut, and whether each is traced on a window of its own."""
    cells = field.heights.size * (1 if field.periodic else 4)
    if cells <= LARGE:
        return PIECES, False
    rows = correlation_lengths(field.patch, "")[1:]
    around = [AROUND * row.value / step for row, step in zip(rows, field.step, strict=True)]
    number = PIECES
    while 2 * max(field.heights.shape) > WINDOW * np.sqrt(number):
        number *= 4
    # Wider windows where these have too little around.
    for of in (number, number // 4):
        room = np.array(field.heights.shape) / np.sqrt(of) / 2
        if of >= PIECES and np.all(room >= around):
            return of, True
    return PIECES, False


def parts(field: HeightField, number: int, windows: bool) -> Iterator[Part]:
    """All pieces, one after the other."""
    for i in range(number):
        yield piece_of(field, i, number, windows)


def piece_of(field: HeightField, i: int, number: int, windows: bool) -> Part:
    """Piece `i` of them."""
    if windows:
        return Part(field.window(i, number), (0, 4))
    return Part(field, field.piece(i, number))


def light_on(
    part: Part,
    material: Material,
    wi: Array,
    rays: int,
    rng: np.random.Generator,
    orders: int,
    max_order: int,
) -> Tally:
    """The light of `rays` rays from `wi` (3,) that start on one piece."""
    stretch = part.field.stretch(float(np.arctan2(wi[1], wi[0])))
    tracer, tally = Tracer(part.field.surface, stretch, material), Tally(orders, independent=False)
    for light in tracer.trace(wi, rays, rng, max_order, part.place):
        tally.add(light)
    return tally


@dataclass
class Job:
    """A scene on a piece of a surface; its slopes are what was fitted, and not what is traced."""

    scene: Scene
    part: Part
    number: int
    rays: int
    """For each incident angle."""
    paths: FreePaths
    seed: int
    max_order: int


def trace(job: Job) -> tuple[list[Tally], Array, Array, int]:
    """A unit for each incident angle; shares (theta, starts, bins + 1) of free paths, weights
    (theta, starts), and free paths lost."""
    units = []
    for i, theta in enumerate(job.scene.theta):
        rng, scene = stream(job.seed, "rays", job.number, i), job.scene
        light = scene.material, scene.wi(theta), job.rays, rng, scene.orders, job.max_order
        units.append(light_on(job.part, *light).as_unit())
    return units, *_free_paths(job)


def free_paths_of(rays: int) -> int:
    """Free paths of a row and piece, for so many rays of an incident angle."""
    return max(round(rays * FREE_PATHS_OF_RAYS), 1)


def _free_paths(job: Job) -> tuple[Array, Array, int]:
    field, place = job.part
    rng, paths = stream(job.seed, "free-path rays", job.number), job.paths
    tracer = FreePathTracer(field.surface, Views(field.stretch(job.scene.phi), 1))
    rows, n = (len(paths.theta), len(paths.starts)), free_paths_of(job.rays)
    shares, weights, lost = np.zeros((*rows, paths.edges.size)), np.zeros(rows), 0
    for i, theta in enumerate(paths.theta):
        d = direction(theta, job.scene.phi)
        for j, start in enumerate(paths.starts):
            found = tracer.next_heights(d, start, n, rng, place)
            heights = found.heights, paths.edges
            shares[i, j, :-1] = np.histogram(*heights, weights=found.shares)[0]
            shares[i, j, -1] = found.escaped
            shares[i, j] /= (found.shares.sum() + found.escaped) or 1
            weights[i, j] = found.weight
            lost += found.lost
    return shares, weights, lost


def simulate_surface(
    scene: Scene,
    field: HeightField,
    samples: int,
    wanted: FreePaths,
    seed: int,
    workers: Workers,
    max_order: int,
    quiet: bool,
) -> Run:
    """`samples` rays for each incident angle on `field`, and free paths as `wanted` says.

    `scene.slopes` are those by which the surface is described; nothing is traced by them. The
    numbers depend on `seed` and not on `workers`.
    """
    started, free_paths = time.monotonic(), wanted.empty()
    number, windows = number_of_pieces(field)
    rays = -(-samples // number)
    jobs = (
        Job(scene, part, i, rays, free_paths, seed, max_order)
        for i, part in enumerate(parts(field, number, windows))
    )
    tallies, groups = [Tally(scene.orders) for _ in scene.theta], LobeGroups(scene, number)
    if not windows:
        # Before threads share it.
        field.surface.build()
    lost, total = 0, rays * number * len(scene.theta)
    with Progress("simulate", total, "rays", quiet) as progress, _pool(workers, windows) as pool:
        traced = enumerate(map_ordered(trace, jobs, pool))
        for i, (units, shares, weights, missing) in traced:
            for tally, unit in zip(tallies, units, strict=True):
                tally.merge(unit)
            groups.add(units, i)
            free_paths.add_unit(shares, weights, free_paths_of(rays))
            lost += missing
            progress.advance(rays * len(scene.theta))
    notes: dict[str, float] = {"pieces": number, "free_paths_lost": lost}
    wall_s = time.monotonic() - started
    return Run("simulate", scene, tallies, free_paths, "gaussian", groups.lobes(), wall_s, notes)


@contextmanager
def _pool(workers: Workers, windows: bool) -> Iterator[Workers]:
    """Processes where each has a window of its own; where one mesh serves all, which is too large
    to have it twice, threads: Embree leaves the interpreter to others."""
    if windows or not isinstance(workers, int) or workers == 1:
        yield workers
        return
    with ThreadPoolExecutor(min(workers, PIECES)) as pool:
        yield pool
