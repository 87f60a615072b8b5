"""The random walk for one incident direction: Smith's, or one that remembers the last facet."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.checks import count, direction_in, kind_of
from msbsdf_cli.memory.remembered import MOST, Remembered
from msbsdf_cli.model import Smith
from msbsdf_cli.results.result import Result
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import random_walk
from msbsdf_cli.statistics.tally import MOST_ORDERS, Tally
from surfaces.facet import Array
from surfaces.light import Light
from surfaces.spectrum import spectrum
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
    memory: Remembered | None = None
    """None: Smith, who remembers nothing."""

    def lights(self) -> Iterator[Light]:
        """The light that leaves."""
        rng = stream(self.seed, "walk", self.index, self.part)
        walks = self.model.slopes, self.model.material, self.wi, self.walks, rng, self.max_order
        if self.memory is None:
            return random_walk(*walks)
        # Not above: few walks need what it is made of.
        from msbsdf_cli.memory import next_facet
        from msbsdf_cli.memory.walk import random_walk as with_memory

        return with_memory(next_facet.Memory.of(*self.memory), *walks)


def remembered_surface(slopes: Slopes, memory: int, autocorrelation: str) -> Remembered | None:
    """What walks remember with `memory`; None for 0. Raises ValueError where there is no such
    walk."""
    if memory not in range(MOST + 1):
        raise ValueError(
            f"memory is {memory}: 0, 1 for the last facet, or 2 for the heights passed since, too."
        )
    if memory == 0:
        return None
    if slopes.name != "beckmann":
        raise ValueError(
            f"the slopes are {slopes.name}: a walk remembers facets of Gaussian surfaces, whose "
            "slopes are beckmann."
        )
    return Remembered(spectrum(autocorrelation), memory)


def run_walks(job: WalkJob) -> tuple[int, Tally]:
    """The index of a job's direction, and the tally of its walks."""
    tally = Tally(job.orders)
    for light in job.lights():
        tally.add(light)
    return job.index, tally


def jobs(
    model: Smith,
    wi: Array,
    samples: int,
    orders: int,
    seed: int,
    max_order: int,
    index: int = 0,
    memory: Remembered | None = None,
) -> Iterator[WalkJob]:
    """The parts of `samples` walks."""
    for part, start in enumerate(range(0, samples, WALKS)):
        walks = min(WALKS, samples - start)
        yield WalkJob(model, wi, orders, walks, seed, index, part, max_order, memory)


def walk(
    model: Smith,
    wi: Array,
    samples: float = 4_000_000,
    seed: int = 0,
    orders: int = 4,
    max_order: int = 10_000,
    precision: str = "float64",
    executor: Workers | None = None,
    memory: int = 0,
    autocorrelation: str = "gaussian",
) -> Result:
    """Follow `samples` random walks from the unit vector `wi` (3,), z > 0 ([HHdD16] Algorithm 7).

    With `memory` 1 heights are those of a Gaussian surface of this `autocorrelation`, as far as the
    last facet tells of them (`msbsdf_cli.memory`), with 2 as far as that and the heights that the
    ray has passed do; with 0, Smith's, who takes them as independent.
    What is still under way after `max_order` facets counts as unresolved. `executor` is anything
    with `submit`, or a number of processes; without it the walks run here. The numbers depend on
    `seed` alone. Raises ValueError for what is out of range.
    """
    kind_of(model, Smith, "a model, such as Smith(Ggx(0.5, 0.5), Conductor()),")
    wi = direction_in(wi).astype(np.dtype(precision))
    samples, orders = count(samples, "samples"), count(orders, "orders", most=MOST_ORDERS)
    seed, max_order = count(seed, "seed", 0), count(max_order, "max_order")
    spectrum(autocorrelation)
    remembered = remembered_surface(model.slopes, memory, autocorrelation)
    total = Tally(orders)
    parts = jobs(model, wi, samples, orders, seed, max_order, memory=remembered)
    for _, tally in map_ordered(run_walks, parts, executor or 1):
        total.merge(tally)
    settings = model.settings() | {
        "wi": wi.tolist(),
        "orders": orders,
        "max_order": max_order,
        "precision": precision,
    }
    if remembered is not None:
        settings |= {"memory": memory, "autocorrelation": autocorrelation}
    rays = np.array([total.rays, total.rays])
    return Result("walk", settings, (seed,), total.sums, rays, total.facets)
