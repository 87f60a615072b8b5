"""Running the Smith random walk for a scene."""

import time

import numpy as np

from msbsdf_cli.experiments.walk import WALKS, jobs, run_walks
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
) -> Run:
    """`samples` walks for each incident angle, and as many free paths in all for each row.

    The numbers depend on `seed` and not on `workers`.
    """
    started, free_paths = time.monotonic(), wanted.empty()
    tallies = [Tally(scene.orders) for _ in scene.theta]
    model, dtype = Smith(scene.slopes, scene.material), np.dtype(precision).type
    parts = (
        job
        for i, theta in enumerate(scene.theta)
        for job in jobs(model, scene.wi(theta, dtype), samples, scene.orders, seed, max_order, i)
    )
    with Progress("walk", samples * len(scene.theta), "walks", quiet) as progress:
        for index, tally in map_ordered(run_walks, parts, workers):
            tallies[index].merge(tally)
            progress.advance(tally.rays)
    wall_s = time.monotonic() - started
    rng = stream(seed, "walk free paths")
    walk_free_paths(scene.slopes, scene.phi, height_distribution(heights), free_paths, samples, rng)
    return Run("walk", scene, tallies, free_paths, heights, wall_s=wall_s)


def walk_free_paths(
    slopes: Slopes,
    phi: float,
    heights: Heights,
    free_paths: FreePaths,
    samples: int,
    rng: np.random.Generator,
) -> None:
    """Draw the next facet's height from each start in each direction ([HHdD16] Eqs. 25 to 30)."""
    # Heights fall as t rises: bins in t, from the top of the surface down, then turned round.
    edges = heights.t(free_paths.edges)[::-1]
    n = -(-min(samples, WALKS) // FREE_PATH_UNITS)
    shape = free_paths.sums.shape[1:]
    weight = np.ones(shape[:2])
    for _ in range(FREE_PATH_UNITS):
        share = np.zeros(shape)
        for i, theta in enumerate(free_paths.theta):
            d = direction(theta, phi)[:, None]
            sigma = slopes.sigma(d)
            for j, start in enumerate(free_paths.starts):
                share[i, j] = _shares(heights.t(np.array(start)), d, sigma, edges, n, rng)
        free_paths.add_unit(share, weight, n)


def _shares(
    t: Array, d: Array, sigma: Array, edges: Array, n: int, rng: np.random.Generator
) -> Array:
    escaped, t_next = free_path(np.full(1, t), d, sigma, exponential(n, rng, np.float64))
    bins = np.searchsorted(edges, t_next.compress(~escaped), side="right") - 1
    counts = np.bincount(bins, minlength=edges.size - 1)[: edges.size - 1]
    return np.append(counts[::-1], np.count_nonzero(escaped)) / n
