"""Light on one surface that is given, and not on many that are random.

There is no other realisation of it: error bars come from the scatter of its own pieces, and say how
far another piece of the same kind of surface may be off.
"""

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from msbsdf_cli.experiments.realisations import FREE_PATHS_OF_RAYS, LobeGroups
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.run import Run
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene, direction
from msbsdf_cli.statistics.tally import Tally
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


def light_of_piece(
    field: HeightField,
    material: Material,
    wi: Array,
    rays: int,
    piece: int,
    rng: np.random.Generator,
    tally: Tally,
    max_order: int,
) -> Tally:
    """`tally` with the light of `rays` rays from `wi` (3,) that start on one piece of `field`."""
    stretch = field.stretch(float(np.arctan2(wi[1], wi[0])))
    tracer = Tracer(field.surface, stretch, material)
    for light in tracer.trace(wi, rays, rng, max_order, field.piece(piece, PIECES)):
        tally.add(light)
    return tally


@dataclass
class OwnSurface:
    """A scene on a field: its slopes are what was fitted to it, and not what is traced."""

    scene: Scene
    field: HeightField
    rays: int
    """For each incident angle and piece."""
    paths: FreePaths
    seed: int
    max_order: int

    @cached_property
    def free_paths(self) -> FreePathTracer:
        """Of the surface as it is, whose heights are in standard deviations."""
        return FreePathTracer(self.field.surface, Views(self.field.stretch(self.scene.phi), 1))

    def light(self, piece: int) -> list[Tally]:
        """A unit for each incident angle."""
        units = []
        for i, theta in enumerate(self.scene.theta):
            rng = stream(self.seed, "rays", piece, i)
            tally = Tally(self.scene.orders, independent=False)
            where = self.scene.wi(theta), self.rays, piece
            light_of_piece(self.field, self.scene.material, *where, rng, tally, self.max_order)
            units.append(tally.as_unit())
        return units

    def next_heights(self, piece: int, n: int) -> tuple[Array, Array, int]:
        """Shares (theta, starts, bins + 1), weights (theta, starts), and rays lost."""
        rng, place = stream(self.seed, "free-path rays", piece), self.field.piece(piece, PIECES)
        rows = len(self.paths.theta), len(self.paths.starts)
        shares, weights, lost = np.zeros((*rows, self.paths.edges.size)), np.zeros(rows), 0
        for i, theta in enumerate(self.paths.theta):
            d = direction(theta, self.scene.phi)
            for j, start in enumerate(self.paths.starts):
                found = self.free_paths.next_heights(d, start, n, rng, place)
                shares[i, j, :-1] = np.histogram(
                    found.heights, self.paths.edges, weights=found.shares
                )[0]
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
    rays = -(-samples // PIECES)
    job = OwnSurface(scene, field, rays, free_paths, seed, max_order)
    field.surface.query(np.zeros((3, 1)), np.ones((3, 1)))  # Embree builds in its first call.
    ready = time.monotonic()
    tallies, groups = [Tally(scene.orders) for _ in scene.theta], LobeGroups(scene, PIECES)
    n, lost = max(round(rays * FREE_PATHS_OF_RAYS), 1), 0
    total = rays * PIECES * len(scene.theta)
    with Progress("simulate", total, "rays", quiet) as progress, _threads(workers) as threads:
        for units in map_ordered(job.light, range(PIECES), threads):
            for tally, unit in zip(tallies, units, strict=True):
                tally.merge(unit)
            groups.add(units)
            progress.advance(rays * len(scene.theta))
        paths = map_ordered(partial(job.next_heights, n=n), range(PIECES), threads)
        for shares, weights, missing in paths:
            free_paths.add_unit(shares, weights, n)
            lost += missing
    notes = {"surface_s": ready - started, "rays": field.surface.rays, "free_paths_lost": lost}
    wall_s = time.monotonic() - started
    return Run("simulate", scene, tallies, free_paths, "gaussian", groups.lobes(), wall_s, notes)


@contextmanager
def _threads(workers: Workers) -> Iterator[Workers]:
    """Threads instead of processes: the mesh is too large to have it twice, and Embree leaves the
    interpreter to others."""
    if not isinstance(workers, int) or workers == 1:
        yield workers
        return
    with ThreadPoolExecutor(min(workers, PIECES)) as pool:
        yield pool
