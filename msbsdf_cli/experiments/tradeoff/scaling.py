"""How time grows with samples, processes, orders and roughness: scaling.csv."""

import time
from dataclasses import dataclass, replace
from functools import lru_cache

from msbsdf_cli.experiments.tradeoff.directions import Lobe
from msbsdf_cli.experiments.tradeoff.measuring import (
    RESOLUTIONS,
    Protocol,
    Setting,
    measure,
    quartiles,
)
from msbsdf_cli.experiments.tradeoff.rows import Row
from msbsdf_cli.methods.protocol import Method
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.run.executors import map_ordered
from msbsdf_cli.scene import Scene
from surfaces.streams import stream

ORDERS = (1, 2, 4, 8)
REPEATS = 3
THREAD_PARTS = 8
"""Parts of the work that processes share."""
THREAD_REPEATS = 2
SAMPLES = 1024
"""Walks for the runs over orders and roughness."""
SOLVED = RESOLUTIONS[-2]
"""Resolution of `solve` in these."""


@dataclass(frozen=True)
class Scaling:
    """Seconds of a method for one value of a parameter."""

    parameter: str
    value: float
    method: str
    theta_i_rad: float
    samples: int
    seconds: float
    seconds_low: float
    seconds_high: float
    setup_s: float
    relative_rmse: float = float("nan")
    relative_rmse_stderr: float = float("nan")
    efficiency: float = float("nan")


def of_rows(parameter: str, rows: list[Row]) -> list[Scaling]:
    """From rows of the chart: `parameter` is `samples` or `roughness`."""
    return [
        Scaling(
            parameter,
            r.samples if parameter == "samples" else r.alpha_x,
            r.method,
            r.theta_i_rad,
            r.samples,
            r.seconds,
            r.seconds_low,
            r.seconds_high,
            r.setup_s,
            r.relative_rmse,
            r.relative_rmse_stderr,
            r.efficiency,
        )
        for r in rows
        if r.reference == "smith" and (r.samples or parameter != "samples")
    ]


def one_each(methods: tuple[str, ...], samples: int = SAMPLES) -> list[Setting]:
    """One setting of each method."""
    return [
        Setting(name, resolution=SOLVED)
        if name == "solve"
        else Setting(name, 0 if METHODS[name].deterministic else samples)
        for name in methods
    ]


def over_orders(
    scene: Scene, methods: tuple[str, ...], lobe: Lobe, protocol: Protocol
) -> list[Scaling]:
    """Time over the orders that are told apart."""
    rows = []
    for orders in ORDERS:
        few = replace(protocol, replicates=REPEATS, purpose=f"orders {orders}")
        for s in measure(replace(scene, orders=orders), one_each(methods), [lobe], few):
            low, middle, high = s.times
            place = s.setting.method, lobe.theta, s.setting.samples
            rows.append(Scaling("orders", orders, *place, middle, low, high, s.setup_s[1]))
    return rows


@dataclass(frozen=True)
class ShareJob:
    """A part of the work that processes share."""

    scene: Scene
    setting: Setting
    lobe: Lobe
    seed: int
    place: tuple[int | str, ...]


def do_share(job: ShareJob) -> None:
    """Evaluate, for the time it takes."""
    rng = stream(job.seed, "shared work", *job.place)
    _made(job.setting, job.scene).evaluate(job.lobe.wi, job.lobe.wo, job.setting.samples, rng)


@lru_cache(maxsize=1)
def _made(setting: Setting, scene: Scene) -> Method:
    return setting.make(scene)


def over_threads(
    scene: Scene, settings: list[Setting], lobe: Lobe, workers: int, seed: int
) -> list[Scaling]:
    """Time of the same work on 1, 2, 4 ... and all processes, starting these included; methods
    without noise have nothing to share but angles and are left out."""
    counts = sorted({min(1 << k, workers) for k in range(workers.bit_length() + 1)})
    seconds: dict[tuple[Setting, int], list[float]] = {}
    for r in range(THREAD_REPEATS):
        for setting in (s for s in settings if not s.deterministic):
            for count in counts:
                places = [(setting.method, r, part) for part in range(THREAD_PARTS)]
                jobs = [ShareJob(scene, setting, lobe, seed, place) for place in places]
                started = time.perf_counter()
                for _ in map_ordered(do_share, jobs, count):
                    pass
                seconds.setdefault((setting, count), []).append(time.perf_counter() - started)
    rows = []
    for (setting, count), times in seconds.items():
        low, middle, high = quartiles(times)
        place = setting.method, lobe.theta, THREAD_PARTS * setting.samples
        rows.append(Scaling("threads", count, *place, middle, low, high, 0.0))
    return rows
