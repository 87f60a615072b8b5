"""Directional albedo of every method: what comes back of light from everywhere, all the same.

By reciprocity it is also how bright a surface is under constant white light. The first bounce is
the mean weight of its own sampler; what the method adds to it is integrated by Monte Carlo over
outgoing directions, with an estimate of the method's own noise in it. A method that knows its
energy without adding up values is asked. The standard error is the spread of repetitions and, in
quadrature, a bound on undersampling: rare bounces that none of them met are not in their spread.
So is the error that a method without noise states of its values, which is no noise.
"""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.outgoing_directions import outgoing_directions
from msbsdf_cli.experiments.slices import channel_names
from msbsdf_cli.methods.base import outgoing
from msbsdf_cli.methods.protocol import Method
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.methods.single import Single, first_order
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.results.files import Table
from msbsdf_cli.results.lobes import order_names
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene, direction
from surfaces.facet import Array
from surfaces.streams import stream

REPEATS = 16
"""At least so many independent repetitions, whose spread is the standard error."""
DIRECTIONS = 256
"""Outgoing directions of a repetition, and walks if there are more than enough repetitions: noise
comes from both alike."""
QUARTER = 5
"""Azimuths from the x to the y axis, where the two roughnesses differ."""
FIRST = 16384
"""Samples of the first bounce of a repetition."""


@dataclass(frozen=True)
class FurnaceJob:
    """One method at one roughness, all angles."""

    scene: Scene
    method: str
    samples: int
    seed: int
    accuracy: float | None
    """Wanted of `solve`."""
    autocorrelation: str = "gaussian"
    """Of the surfaces that a method remembers."""


@dataclass
class Albedos:
    """Albedo and standard error of a method at a roughness, (phi, theta, channels, orders + 2):
    orders 1 to K, all the later ones, and all together."""

    method: str
    alpha: tuple[float, float]
    phi: tuple[float, ...]
    """Incident azimuths in radians, the scene's own first."""
    value: Array
    stderr: Array


def furnace(
    scene: Scene,
    alphas: tuple[tuple[float, float], ...],
    methods: tuple[str, ...],
    samples: int,
    seed: int,
    accuracy: float | None,
    workers: Workers,
    quiet: bool,
    autocorrelation: str = "gaussian",
) -> list[Albedos]:
    """All methods at all roughnesses, for the incident angles of `scene`."""
    jobs = [
        FurnaceJob(scene.of_roughness(alpha), name, samples, seed, accuracy, autocorrelation)
        for name in methods
        for alpha in alphas
    ]
    results = []
    with Progress("furnace", len(jobs), "surfaces", quiet) as progress:
        for result in map_ordered(run_furnace, jobs, workers):
            results.append(result)
            progress.advance(1)
    return results


def run_furnace(job: FurnaceJob) -> Albedos:
    """Albedos of one method at one roughness."""
    phis = azimuths(job.scene)
    rows = [sums.estimate() for sums in albedo_sums(job)]
    shape = len(phis), len(job.scene.theta), 2, *np.shape(rows[0])[1:]
    value, stderr = np.moveaxis(np.array(rows).reshape(shape), 2, 0)
    return Albedos(job.method, job.scene.alpha, phis, value, stderr)


@dataclass
class AlbedoSums:
    """Sums over repetitions of one method's albedos for one direction; those of other repetitions
    add up to them."""

    deterministic: bool
    """Whether the method draws nothing."""
    counts: Array
    """Repetitions, and walks of them all; no walks where the method was asked for its albedo."""
    sums: Array
    """Of albedos, of their squares and of errors stated, (3, channels, orders + 2)."""

    def estimate(self) -> tuple[Array, Array]:
        """Albedos and standard errors, (channels, orders + 2) each."""
        n, walks = (int(count) for count in self.counts)
        mean, square, stated = self.sums / n
        if walks == 0:
            return mean, stated
        spread = np.maximum(square - mean * mean, 0) / max(n - 1, 1)
        undersampled = _unseen(self.deterministic, walks, n * FIRST, mean.shape[1] - 2)
        return mean, np.sqrt(spread + undersampled**2 + stated**2)


def albedo_sums(job: FurnaceJob) -> list[AlbedoSums]:
    """Of all azimuths, and for each of all incident angles."""
    scene = job.scene
    arguments = scene.slopes, scene.material, scene.orders
    directions = np.stack([direction(t, p) for p in azimuths(scene) for t in scene.theta], axis=1)
    if job.method == Solve.name and job.accuracy is not None:
        method: Method = Solve.accurate(*arguments, directions, job.accuracy)
    else:
        method = METHODS[job.method].on(*arguments, job.autocorrelation)
    single = Single(*arguments)
    return [_sums(job, method, single, i, wi) for i, wi in enumerate(directions.T)]


def _sums(job: FurnaceJob, method: Method, single: Single, i: int, wi: Array) -> AlbedoSums:
    known = method.albedo(wi)
    if known is not None:
        value, stated = (_with_total(a) for a in known)
        counts = np.array([1, 0])
        return AlbedoSums(method.deterministic, counts, np.array([value, value**2, stated]))
    n = max(REPEATS, job.samples // DIRECTIONS)
    walks = -(-job.samples // n)
    place = job.method, repr(job.scene.alpha), i
    streams = (stream(job.seed, "furnace", *place, repeat) for repeat in range(n))
    repeats = [_integrate(method, single, wi, walks, rng) for rng in streams]
    mean, stated = np.moveaxis(np.array(repeats), 1, 0)
    sums = np.array([mean.sum(axis=0), (mean**2).sum(axis=0), stated.sum(axis=0)])
    return AlbedoSums(method.deterministic, np.array([n, n * walks]), sums)


def azimuths(scene: Scene) -> tuple[float, ...]:
    """The scene's azimuth, and of two roughnesses a grid over the quarter turn, which by symmetry
    stands for the whole one."""
    if scene.alpha[0] == scene.alpha[1]:
        return (scene.phi,)
    return tuple(dict.fromkeys((scene.phi, *np.linspace(0, np.pi / 2, QUARTER).tolist())))


def _integrate(
    method: Method, single: Single, wi: Array, walks: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """One repetition: albedos (channels, orders + 2), and what errors that a method without noise
    states of its values come to, likewise."""
    first = single.sample(wi, FIRST, rng)[1].mean(axis=1)
    wo, share = outgoing_directions(single, wi, DIRECTIONS, rng)
    found = method.evaluate(wi, wo, walks, rng)
    added = found.value.copy()
    added[:, 0] -= first_order(single.slopes, single.material, wi, outgoing(single.slopes, wo))
    orders = added @ share
    orders[:, 0] += first
    stated = found.stderr @ share if method.deterministic else np.zeros_like(orders)
    return _with_total(orders), _with_total(stated)


def _unseen(deterministic: bool, walks: int, first: int, orders: int) -> Array:
    """What paths that none of the walks has met may add to the albedos, (orders + 2,).

    A walk carries at most all of the light, so that what has not happened in n walks is worth
    about 1 / n. The first bounce is drawn `first` times; after that a method without noise adds
    nothing that could be missed, and one with noise draws `walks` of them.
    """
    later = 0.0 if deterministic else 1 / walks
    undersampled = np.full(orders + 2, later)
    undersampled[0] = 1 / first
    undersampled[-1] = max(later, 1 / first)
    return undersampled


def _with_total(orders: Array) -> Array:
    """(channels, orders + 1) and their sum."""
    return np.concatenate([orders, orders.sum(axis=1, keepdims=True)], axis=1)


def furnace_table(scene: Scene, results: list[Albedos]) -> Table:
    """furnace.csv"""
    names = ("method", "material", "slopes", "alpha_x", "alpha_y", "theta_i_rad", "order")
    table: dict[str, list[float | str]] = {
        name: [] for name in (*names, "albedo", "stderr", "channel", "phi_i_rad")
    }
    orders = [*order_names(scene.orders), "all"]
    for result in results:
        channels = channel_names(result.value.shape[2])
        for place in np.ndindex(result.value.shape):
            p, i, c, k = place
            row: tuple[float | str, ...] = (
                result.method,
                scene.material.name,
                scene.slopes.name,
                *result.alpha,
                scene.theta[i],
                orders[k],
                float(result.value[place]),
                float(result.stderr[place]),
                channels[c],
                result.phi[p],
            )
            for column, cell in zip(table.values(), row, strict=True):
                column.append(cell)
    return table
