"""Running the random walk for a scene."""

import time
from collections.abc import Callable

import numpy as np

from msbsdf_cli.experiments.walk import WALKS, jobs, run_walks
from msbsdf_cli.memory.remembered import Remembered
from msbsdf_cli.model import Smith
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.run import Run
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene, direction
from msbsdf_cli.smith.heights import Heights, height_distribution
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import exponential, free_path
from msbsdf_cli.statistics.tally import Tally
from surfaces.facet import Array
from surfaces.streams import stream

FREE_PATH_UNITS = 64
"""Independent parts into which the free paths of a row are divided for their standard error."""


def walk(
    scene: Scene,
    samples: int,
    wanted: FreePaths,
    heights: str,
    seed: int,
    workers: Workers,
    precision: str,
    max_order: int,
    quiet: bool,
    memory: Remembered | None = None,
) -> Run:
    """`samples` walks for each incident angle, and as many free paths in all for each row.

    With `memory`, walks and free paths remember the surface. The numbers depend on `seed` and not
    on `workers`.
    """
    started, free_paths = time.monotonic(), wanted.empty()
    tallies = [Tally(scene.orders) for _ in scene.theta]
    model, dtype = Smith(scene.slopes, scene.material), np.dtype(precision).type
    parts = (
        job
        for i, theta in enumerate(scene.theta)
        for job in jobs(
            model, scene.wi(theta, dtype), samples, scene.orders, seed, max_order, i, memory
        )
    )
    with Progress("walk", samples * len(scene.theta), "walks", quiet) as progress:
        for index, tally in map_ordered(run_walks, parts, workers):
            tallies[index].merge(tally)
            progress.advance(tally.rays)
    wall_s = time.monotonic() - started
    add_free_paths(scene, free_paths, heights, samples, seed, memory)
    remembers = 0 if memory is None else memory.number
    return Run("walk", scene, tallies, free_paths, heights, wall_s=wall_s, memory=remembers)


def add_free_paths(
    scene: Scene,
    free_paths: FreePaths,
    heights: str,
    samples: int,
    seed: int,
    memory: Remembered | None = None,
) -> None:
    """Draw about `samples` free paths for each row of `free_paths`, or `WALKS` if that is less."""
    if memory is None:
        draw = smith_shares(scene.slopes, height_distribution(heights), free_paths.edges)
    else:
        from msbsdf_cli.memory.free_paths import shares

        draw = shares(memory, scene.slopes, free_paths.edges)
    walk_free_paths(draw, scene.phi, free_paths, samples, stream(seed, "walk free paths"))


Shares = Callable[[Array, float, int, np.random.Generator], Array]
"""Shares (bins + 1,) of free paths along a direction (3, 1) from a height that next meet heights in
bins, the last of those that escape; of so many."""


def walk_free_paths(
    draw: Shares, phi: float, free_paths: FreePaths, samples: int, rng: np.random.Generator
) -> None:
    """Draw the next facet's height from each start in each direction ([HHdD16] Eqs. 25 to 30)."""
    n = -(-min(samples, WALKS) // FREE_PATH_UNITS)
    shape = free_paths.sums.shape[1:]
    weight = np.ones(shape[:2])
    for _ in range(FREE_PATH_UNITS):
        share = np.zeros(shape)
        for i, theta in enumerate(free_paths.theta):
            d = direction(theta, phi)[:, None]
            for j, start in enumerate(free_paths.starts):
                share[i, j] = draw(d, start, n, rng)
        free_paths.add_unit(share, weight, n)


def smith_shares(slopes: Slopes, heights: Heights, edges: Array) -> Shares:
    """Of the Smith model."""
    # Heights fall as t rises: bins in t, from the top of the surface down, then turned round.
    in_t = heights.t(edges)[::-1]

    def draw(d: Array, start: float, n: int, rng: np.random.Generator) -> Array:
        t, E = np.full(1, heights.t(np.array(start))), exponential(n, rng, np.float64)
        escaped, t_next = free_path(t, d, slopes.sigma(d), E)
        bins = np.searchsorted(in_t, t_next.compress(~escaped), side="right") - 1
        counts = np.bincount(bins, minlength=in_t.size - 1)[: in_t.size - 1]
        return np.append(counts[::-1], np.count_nonzero(escaped)) / n

    return draw
