"""The Smith random walk for one incident direction."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.checks import count, direction_in
from msbsdf_cli.model import Smith
from msbsdf_cli.results.result import Result
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.smith.walk import random_walk
from msbsdf_cli.statistics.tally import Tally
from surfaces.facet import Array
from surfaces.streams import stream

WALKS = 1 << 18
"""Walks in a job: enough that the last few of many bounces cost little, few enough that a job
takes some hundredths of a second and its lanes a few megabytes."""


@dataclass(frozen=True)
class WalkJob:
    """Walks of one incident direction, the `index`-th of a run, numbered `part`."""

    model: Smith
    wi: Array
    """Unit vector (3,), in the precision of the walk."""
    orders: int
    walks: int
    seed: int
    index: int
    part: int
    max_order: int


def run_walks(job: WalkJob) -> tuple[int, Tally]:
    """The index of a job's direction, and the tally of its walks."""
    rng = stream(job.seed, "walk", job.index, job.part)
    tally = Tally(job.orders)
    slopes, material = job.model.slopes, job.model.material
    for light in random_walk(slopes, material, job.wi, job.walks, rng, job.max_order):
        tally.add(light)
    return job.index, tally


def jobs(
    model: Smith, wi: Array, samples: int, orders: int, seed: int, max_order: int, index: int = 0
) -> Iterator[WalkJob]:
    """The parts of `samples` walks."""
    for part, start in enumerate(range(0, samples, WALKS)):
        walks = min(WALKS, samples - start)
        yield WalkJob(model, wi, orders, walks, seed, index, part, max_order)


def walk(
    model: Smith,
    wi: Array,
    samples: float = 4_000_000,
    seed: int = 0,
    orders: int = 4,
    max_order: int = 10_000,
    precision: str = "float64",
    executor: Workers | None = None,
) -> Result:
    """Follow `samples` random walks from the unit vector `wi` (3,), z > 0 ([HHdD16] Algorithm 7).

    What is still under way after `max_order` facets counts as unresolved. `executor` is anything
    with `submit`, or a number of processes; without it the walks run here. The numbers depend on
    `seed` alone. Raises ValueError for what is out of range.
    """
    wi = direction_in(wi).astype(np.dtype(precision))
    samples, orders = count(samples, "samples"), count(orders, "orders")
    seed, max_order = count(seed, "seed", 0), count(max_order, "max_order")
    total = Tally(orders)
    parts = jobs(model, wi, samples, orders, seed, max_order)
    for _, tally in map_ordered(run_walks, parts, executor or 1):
        total.merge(tally)
    settings = model.settings() | {
        "wi": wi.tolist(),
        "orders": orders,
        "max_order": max_order,
        "precision": precision,
    }
    rays = np.array([total.rays, total.rays])
    return Result("walk", settings, (seed,), total.sums, rays, total.facets)
