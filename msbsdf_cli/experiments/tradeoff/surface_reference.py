"""The floor under all effort: how far models are from explicit surfaces.

Light of models and of surfaces is counted in the same bins, whose means need no interpolation.
Distances are relative root mean squares over bins, weighted by solid angle as those of the methods
are, and free of noise in the mean: products of independent units stand in for squares.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.control_variates import NUMBER, expected
from msbsdf_cli.experiments.random_surfaces import Resolution
from msbsdf_cli.experiments.realisations import SurfaceJob, trace_surface
from msbsdf_cli.experiments.tradeoff.known_energies import FEWEST, Known, Spent, known
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene
from msbsdf_cli.statistics.binning import (
    PHI_BINS,
    THETA_BINS,
    lobe_bin,
    merge_sides,
    merged_solid_angle,
)
from msbsdf_cli.statistics.discretisation import on_all_meshes
from msbsdf_cli.statistics.jackknife import jackknife
from msbsdf_cli.statistics.repetitions import root
from msbsdf_cli.statistics.surface_tally import SurfaceTally
from surfaces.facet import Array
from surfaces.streams import stream

PARTS = 8
PART_SAMPLES = 32768
"""Independent parts of a model's lobe, and samples of each."""

FEWEST_GROUPS = 4
"""Of units, to tell their spread from."""


@dataclass(frozen=True)
class Distance:
    """How far a model's lobe is from the surfaces', relative to theirs."""

    theta: float
    model: str
    value: float
    stderr: float


@dataclass(frozen=True)
class SurfaceReference:
    """Surfaces traced: lobes, one unit for each realisation, and what they took."""

    units: Array
    """Energy in bins (realisations, angles, bins)."""
    spent: list[Spent]
    """Seconds for each surface."""
    steps: list[list[Known]]
    """What is known of each angle's energies after ever more surfaces."""
    rays: int
    """Of one angle on one surface."""


def trace_surfaces(
    scene: Scene, resolution: Resolution, samples: int, seed: int, workers: Workers, quiet: bool
) -> SurfaceReference:
    """`samples` rays for each incident angle, spread over the realisations."""
    number, angles = resolution.realisations, len(scene.theta)
    rays = -(-samples // number)
    expect = tuple(expected(scene.slopes, scene.wi(theta)) for theta in scene.theta)
    fixed = (), (), (0.0, 1.0), seed, 10_000, expect
    jobs = (
        SurfaceJob(scene, resolution, i, rays, *fixed, on_all_meshes=i < on_all_meshes(number))
        for i in range(number)
    )
    tallies = [SurfaceTally(scene.orders, NUMBER, resolution.extent) for _ in scene.theta]
    units, spent = [], []
    steps: list[list[Known]] = [[] for _ in scene.theta]
    with Progress("surfaces", number, "surfaces", quiet) as progress:
        for result in map_ordered(trace_surface, jobs, workers):
            lobes = [mine.unit.estimate("lobe").value.sum(axis=0) for mine in result.light]
            units.append([merge_sides(lobe) for lobe in lobes])
            spent.append(
                Spent(result.surface_s, result.trace_s / angles, result.coarser_s / angles)
            )
            for tally, light, step in zip(tallies, result.light, steps, strict=True):
                tally.add_surface(light)
                if is_step(tally.units, number):
                    step.append(known(tally))
            progress.advance(1)
    return SurfaceReference(np.array(units), spent, steps, rays)


def is_step(surfaces: int, most: int) -> bool:
    """Whether so many surfaces make a row: 8, 16, 32, ..., and all."""
    return surfaces == most or (surfaces >= FEWEST and surfaces & (surfaces - 1) == 0)


@dataclass(frozen=True)
class ModelJob:
    """One part of the samples of a model for all incident angles."""

    scene: Scene
    model: str
    part: int
    seed: int
    autocorrelation: str


def sample_model(job: ModelJob) -> Array:
    """Energy in merged bins (angles, bins), of the first channel."""
    scene = job.scene
    of = scene.slopes, scene.material, scene.orders
    method = METHODS[job.model].on(*of, job.autocorrelation)
    lobes = []
    for i, theta in enumerate(scene.theta):
        rng = stream(job.seed, "model lobe", job.model, i, job.part)
        w, weight = method.sample(scene.wi(theta), PART_SAMPLES, rng)
        sides = [
            np.bincount(lobe_bin(w[:, there]), weight[0, there], THETA_BINS * PHI_BINS)
            for there in (w[2] > 0, w[2] < 0)
        ]
        lobes.append(merge_sides(np.stack(sides) / PART_SAMPLES))
    return np.array(lobes)


def sampler(model: str) -> str:
    """The first method that draws from a model."""
    return next(n for n, m in METHODS.items() if m.traits.model == model and m.traits.samples)


def distances(
    scene: Scene,
    methods: tuple[str, ...],
    surfaces: SurfaceReference,
    seed: int,
    workers: Workers,
    autocorrelation: str,
) -> list[Distance]:
    """Of the models behind the methods, and always of the Smith model."""
    models = dict.fromkeys(["smith", *(METHODS[name].traits.model for name in methods)])
    jobs = [
        ModelJob(scene, sampler(model), part, seed, autocorrelation)
        for model in models
        for part in range(PARTS)
    ]
    results = list(map_ordered(sample_model, jobs, workers))
    solid_angle = merged_solid_angle()
    found = []
    for k, model in enumerate(models):
        lobes = np.array(results[k * PARTS : (k + 1) * PARTS])
        for i, theta in enumerate(scene.theta):
            square, stderr = distance(surfaces.units[:, i], lobes[:, i], solid_angle)
            found.append(Distance(theta, model, *root(square, stderr)))
    return found


def distance(truth: Array, model: Array, solid_angle: Array) -> tuple[float, float]:
    """Squared relative distance of two means of energies in bins, from units (r, bins) of the one
    and (s, bins) of the other, and its standard error."""
    truth, model = truth / np.sqrt(solid_angle), model / np.sqrt(solid_angle)
    from_truth = jackknife(np.array([_relative_square(a, model) for a in _left_out(truth)]))
    from_model = jackknife(np.array([_relative_square(truth, b) for b in _left_out(model)]))
    return _relative_square(truth, model), float(np.hypot(from_truth, from_model))


def _relative_square(truth: Array, model: Array) -> float:
    apart = truth.mean(axis=0) - model.mean(axis=0)
    noise = noise_of_mean(truth)
    square = apart @ apart - noise - noise_of_mean(model)
    return float(square / (truth.mean(axis=0) @ truth.mean(axis=0) - noise))


def noise_of_mean(units: Array) -> float:
    """Squared noise of the mean of units (r, bins), summed over bins."""
    return float(units.var(axis=0, ddof=1).sum() / len(units))


def _left_out(units: Array) -> Iterator[Array]:
    for i in range(len(units)):
        yield np.delete(units, i, axis=0)


def own_noise(surfaces: SurfaceReference, angle: int) -> tuple[float, float]:
    """Relative noise of the mean over all surfaces, and its standard error."""
    _, noise, stderr = grouped_noise(surfaces.units[:, angle])[0]
    return noise / np.sqrt(len(surfaces.units)), stderr / np.sqrt(len(surfaces.units))


def grouped_noise(units: Array) -> list[tuple[int, float, float]]:
    """Units (n, bins) used, the relative noise of as many, and its standard error; measured between
    groups of units, as long as these are enough."""
    units = units / np.sqrt(merged_solid_angle())
    mean = units.mean(axis=0)
    scale = mean @ mean - noise_of_mean(units)
    found = []
    size = 1
    while size == 1 or len(units) // size >= FEWEST_GROUPS:
        groups = len(units) // size
        means = units[: groups * size].reshape(groups, size, -1).mean(axis=1)
        each = ((means - means.mean(axis=0)) ** 2).sum(axis=1) * groups / (groups - 1) / scale
        stderr = each.std(ddof=1) / np.sqrt(groups)
        found.append((size, *root(float(each.mean()), float(stderr))))
        size *= 2
    return found
