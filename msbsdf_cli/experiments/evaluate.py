"""Evaluating methods for all incident angles of a scene, on all cores."""

import time
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from msbsdf_cli.methods.position_free import PositionFree
from msbsdf_cli.methods.protocol import Evaluation, Method
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material
from surfaces.streams import stream

PARTS = 16
PART = 100_000
"""At least so many independent parts of the samples of a method, and of at most so many samples:
the spread between them is the standard error of the sum over orders, whose terms come from the
same walks."""


@dataclass(frozen=True)
class EvaluationJob:
    """One part of a method's samples for one incident angle, or, of a method without noise, all
    angles, since they share its set-up."""

    scene: Scene
    method: str
    angles: tuple[int, ...]
    """Places of the incident angles in the scene."""
    part: int
    samples: int
    seed: int
    precision: str
    wo: Array
    """Outgoing directions (3, n)."""
    bidirectional: bool
    """Whether position-free models follow paths from both ends."""
    autocorrelation: str = "gaussian"
    """Of the surfaces that a method remembers."""


@dataclass
class Values:
    """BSDF x cos(theta_o) of a method, per steradian: (channels, orders + 2, n), orders 1 to K,
    all the later ones, and all orders together."""

    method: str
    theta: float
    value: Array
    stderr: Array
    unresolved: float
    seconds: float
    """Of all parts together, on one core each."""
    energy: Array | None = None
    """Energy of each order and side and its standard error, (2, channels, orders + 1, 2)."""
    groups: Array | None = None
    """Totals by independent groups of the samples, (groups, channels, n), whose scatter is that of
    anything made of several directions; None of a method without noise."""


def evaluate(
    scene: Scene,
    methods: tuple[str, ...],
    wo: Array,
    samples: int,
    seed: int,
    workers: Workers,
    precision: str,
    quiet: bool,
    solid_angle: Array | None = None,
    bidirectional: bool = False,
    autocorrelation: str = "gaussian",
) -> list[Values]:
    """All methods for all incident angles and outgoing directions (3, n), angle by angle.

    Directions (k, 3, n) are averaged over k: parts of the samples take them in turn, so that they
    cost no more, and a method without noise does all of them. `solid_angle` (n,) makes the
    directions a quadrature, and energies of it. `bidirectional` is for the position-free models,
    see `msbsdf_cli.methods.position_free`, `autocorrelation` that of the surfaces which
    `walk-memory` remembers.
    Raises `UnsupportedError` where a method does not hold for the scene.
    """
    turns = wo.reshape(-1, *wo.shape[-2:])
    jobs = []
    for name in methods:
        noiseless = METHODS[name].deterministic
        sizes = [1] * len(turns) if noiseless else part_sizes(samples, len(turns))
        for angles in _shared_angles(len(scene.theta), noiseless):
            for k, size in enumerate(sizes):
                ends = turns[k % len(turns)]
                how = seed, precision, ends, bidirectional, autocorrelation
                jobs.append(EvaluationJob(scene, name, angles, k, size, *how))
    parts: dict[tuple[int, str], list[Part]] = {}
    with Progress("evaluate", len(jobs), "parts", quiet) as progress:
        for job, results in zip(jobs, map_ordered(run_job, jobs, workers), strict=True):
            for i, part in zip(job.angles, results, strict=True):
                parts.setdefault((i, job.method), []).append(part)
            progress.advance(1)
    return [
        _merge(name, theta, parts[i, name], turns, solid_angle)
        for i, theta in enumerate(scene.theta)
        for name in methods
    ]


class Part(NamedTuple):
    """What a job came to."""

    samples: int
    evaluation: Evaluation
    undersampled: Array
    """Error of paths that no walk has found, (channels, n)."""
    seconds: float


def part_sizes(samples: int, turns: int) -> list[int]:
    """Sizes of the parts: two for each turn and as many for all, but of two walks at least."""
    count = max(PARTS, 2 * turns if turns > 1 else 1, -(-samples // PART))
    count = min(-(-count // turns) * turns, max(samples // 2, 1))
    return [samples // count + (i < samples % count) for i in range(count)]


def _shared_angles(count: int, deterministic: bool) -> list[tuple[int, ...]]:
    return [tuple(range(count))] if deterministic else [(i,) for i in range(count)]


def run_job(job: EvaluationJob) -> list[Part]:
    """Evaluate one part for its angles; the time of the first includes the method's set-up."""
    scene = job.scene
    dtype = np.dtype(job.precision).type
    wo = job.wo.astype(dtype)
    parts = []
    for i in job.angles:
        started = time.perf_counter()
        arguments = scene.slopes, scene.material, scene.orders
        method = _method(job.method, *arguments, job.bidirectional, job.autocorrelation)
        rng = stream(job.seed, "evaluate", job.method, i, job.part)
        wi = scene.wi(scene.theta[i], dtype)
        evaluation = method.evaluate(wi, wo, job.samples, rng)
        seconds = time.perf_counter() - started
        undersampled = method.undersampling(wi, wo, job.samples, rng)
        parts.append(Part(job.samples, evaluation, undersampled, seconds))
    return parts


@lru_cache(maxsize=2)
def _method(
    name: str,
    slopes: Slopes,
    material: Material,
    orders: int,
    bidirectional: bool,
    autocorrelation: str,
) -> Method:
    """Set up once in a process for all parts and angles."""
    arguments = slopes, material, orders
    method = METHODS[name]
    if bidirectional and issubclass(method, PositionFree):
        return method(*arguments, bidirectional=True)
    return method.on(*arguments, autocorrelation)


def _scatter(values: Array, share: Array, turns: int) -> Array:
    """Standard error of the mean of parts (parts, ...) with shares (parts,), from the scatter of
    those that have the same turn; of all, where each has a turn of its own."""
    turn = np.arange(len(values)) % turns
    if len(values) < 2 * turns:
        turn[:] = 0
    variance = np.zeros(values.shape[1:])
    for k in range(int(turn.max()) + 1):
        mine = turn == k
        n = int(np.count_nonzero(mine))
        weight = share[mine].reshape(-1, *[1] * (values.ndim - 1))
        mean = (weight * values[mine]).sum(axis=0) / weight.sum()
        variance += (weight**2 * (values[mine] - mean) ** 2).sum(axis=0) * (n / max(n - 1, 1))
    return np.sqrt(variance)


def _energy(values: Array, share: Array, turns: Array, solid_angle: Array, noise: bool) -> Array:
    """Means over parts (parts, channels, orders + 1, n) of the energy on each side, and standard
    errors; of a method without noise the distance from what the first half of the turns give."""
    sides = np.stack([turns[0, 2] > 0, turns[0, 2] < 0], axis=1) * solid_angle[:, None]
    energies = values @ sides
    mean = np.tensordot(share, energies, 1)
    if noise:
        return np.stack([mean, _scatter(energies, share, len(turns))])
    return np.stack([mean, np.abs(mean - energies[: max(len(turns) // 2, 1)].mean(axis=0))])


def _merge(
    method: str, theta: float, parts: list[Part], turns: Array, solid_angle: Array | None
) -> Values:
    share = np.array([part.samples for part in parts], float)
    share /= share.sum()
    noise = not METHODS[method].deterministic
    values = np.array([part.evaluation.value for part in parts], float)
    stderrs = np.array([part.evaluation.stderr for part in parts], float)
    weight = share[:, None, None, None]
    value, totals = (weight * values).sum(axis=0), values.sum(axis=2)
    # One walk of a part, the brightest that any part knows of, adds less among all.
    undersampled = np.max(
        [s * part.undersampled for s, part in zip(share, parts, strict=True)], axis=0
    )
    if noise:
        stderr = np.sqrt(((weight * stderrs) ** 2).sum(axis=0))
        stderr[:, 1:] = np.hypot(stderr[:, 1:], undersampled[:, None])
        total_stderr = stderr.sum(axis=1)
        if len(parts) > 1:
            total_stderr = np.hypot(_scatter(totals, share, len(turns)), undersampled)
    else:
        stderr = (weight * stderrs).sum(axis=0)
        total_stderr = stderr.sum(axis=1)
    energy = None
    if solid_angle is not None:
        energy = _energy(values, share, turns, solid_angle, noise)
    return Values(
        method,
        theta,
        np.concatenate([value, value.sum(axis=1, keepdims=True)], axis=1),
        np.concatenate([stderr, total_stderr[:, None]], axis=1),
        max(part.evaluation.unresolved for part in parts),
        sum(part.seconds for part in parts),
        energy,
        _groups(totals, share) if noise and len(turns) == 1 and len(parts) > 1 else None,
    )


def _groups(totals: Array, share: Array) -> Array:
    """Means of totals (parts, channels, n) of shares (parts,) over groups of parts."""
    count = min(PARTS, len(totals))
    strided = (slice(k, None, count) for k in range(count))
    return np.array([np.average(totals[k], axis=0, weights=share[k]) for k in strided])
