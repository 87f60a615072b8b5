"""Tracing light on realisations of an explicit surface for a scene."""

import time
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.parallel import Progress, in_order
from msbsdf_cli.run.streams import stream
from msbsdf_cli.scene import Scene, direction
from msbsdf_cli.studies.outcome import FreePaths, Outcome
from msbsdf_cli.tally import Tally
from surfaces.facet import Array
from surfaces.free_path import next_heights
from surfaces.heightfield import all_waves, some_waves, synthesise
from surfaces.surface import Surface
from surfaces.tracing import Tracer

FREE_PATH_SHARE = 1 / 16
"""Free paths of a row for each ray of an incident angle."""


@dataclass(frozen=True)
class Resolution:
    """How finely and how often the surface is made."""

    cells: int
    """Mesh cells a correlation length."""
    extent: int
    """Period, in correlation lengths."""
    realisations: int
    waves: int | None = None
    """Cosines summed; None: every wave of the period's lattice."""


@dataclass(frozen=True)
class SurfaceJob:
    """Everything traced on realisation number `number`."""

    scene: Scene
    resolution: Resolution
    number: int
    rays: int
    """Rays for each incident angle."""
    free_path_theta: tuple[float, ...]
    free_path_starts: tuple[float, ...]
    free_path_edges: tuple[float, ...]
    seed: int
    max_order: int


@dataclass
class SurfaceResult:
    """One unit for each incident angle, free paths, and what it took."""

    tallies: list[Tally]
    free_paths: Array
    free_path_weights: Array
    free_path_rays: int
    """Free paths of each row."""
    rays: int
    """Rays asked of Embree for the incident light."""
    embree_s: float
    surface_s: float
    """Seconds for making the surface and its Embree scene."""
    trace_s: float
    free_paths_lost: int


def realisation(resolution: Resolution, number: int, seed: int) -> Surface:
    """Realisation `number` of the surface; the same field for any number of cells."""
    field = number, resolution.extent, resolution.waves or 0
    return make_surface(resolution, stream(seed, "heightfield", *field))


def make_surface(resolution: Resolution, rng: np.random.Generator) -> Surface:
    """A random surface; from generators in the same state the same field for any cells."""
    if resolution.waves is None:
        amplitudes = all_waves(resolution.extent, rng)
    else:
        amplitudes = some_waves(resolution.extent, resolution.waves, rng)
    heights = synthesise(amplitudes, resolution.extent, resolution.cells)
    return Surface(heights, resolution.cells)


def simulate(
    scene: Scene,
    samples: int,
    resolution: Resolution,
    free_paths: FreePaths,
    seed: int,
    threads: int,
    max_order: int,
    quiet: bool,
) -> Outcome:
    """`samples` rays for each incident angle, spread over the realisations.

    The numbers depend on `seed` and not on `threads`.
    """
    started = time.monotonic()
    rays = -(-samples // resolution.realisations)
    jobs = (
        SurfaceJob(
            scene,
            resolution,
            number,
            rays,
            free_paths.theta,
            free_paths.starts,
            tuple(free_paths.edges),
            seed,
            max_order,
        )
        for number in range(resolution.realisations)
    )
    tallies = [Tally(scene.orders) for _ in scene.theta]
    outcome = Outcome(tallies, free_paths)
    notes = dict.fromkeys(("embree_s", "surface_s", "trace_s", "rays", "free_paths_lost"), 0.0)
    total = rays * resolution.realisations * len(scene.theta)
    with Progress("simulate", total, "rays", quiet) as progress:
        for result in in_order(trace_surface, jobs, threads):
            for tally, unit in zip(tallies, result.tallies, strict=True):
                tally.merge(unit)
            free_paths.add_unit(result.free_paths, result.free_path_weights, result.free_path_rays)
            for name in notes:
                notes[name] += getattr(result, name)
            progress.advance(rays * len(scene.theta))
    outcome.notes = notes
    outcome.wall_s = time.monotonic() - started
    return outcome


def trace_surface(job: SurfaceJob) -> SurfaceResult:
    """Make one surface and trace all incident angles and free paths on it."""
    started = time.perf_counter()
    scene = job.scene
    surface = realisation(job.resolution, job.number, job.seed)
    surface.query(np.zeros((3, 1)), np.ones((3, 1)))  # Embree builds in its first call.
    ready = time.perf_counter()
    surface.rays, surface.embree_s = 0, 0.0
    tracer = Tracer(surface, *scene.alpha, scene.facets())
    units = []
    for i, theta in enumerate(scene.theta):
        rng = stream(job.seed, "rays", job.number, i)
        tally = Tally(scene.orders, independent=False)
        for light in tracer.trace(scene.wi(theta), job.rays, rng, job.max_order):
            tally.add(light)
        units.append(tally.as_unit())
    traced = time.perf_counter()
    rays, embree_s = surface.rays, surface.embree_s
    n = max(round(job.rays * FREE_PATH_SHARE), 1)
    shares, weights, lost = _free_paths(job, tracer, n)
    return SurfaceResult(
        units, shares, weights, n, rays, embree_s, ready - started, traced - ready, lost
    )


def _free_paths(job: SurfaceJob, tracer: Tracer, n: int) -> tuple[Array, Array, int]:
    """Shares (theta, starts, bins + 1), weights (theta, starts), and rays lost."""
    rng = stream(job.seed, "free-path rays", job.number)
    edges = np.array(job.free_path_edges)
    rows = len(job.free_path_theta), len(job.free_path_starts)
    shares, weights, lost = np.zeros((*rows, edges.size)), np.zeros(rows), 0
    for i, theta in enumerate(job.free_path_theta):
        d = direction(theta, job.scene.phi)
        for j, start in enumerate(job.free_path_starts):
            paths = next_heights(tracer.surface, tracer.scale, d, start, n, rng)
            shares[i, j, :-1] = np.histogram(paths.heights, edges)[0]
            shares[i, j, -1] = paths.escaped
            shares[i, j] /= max(paths.heights.size + paths.escaped, 1)
            weights[i, j] = paths.weight
            lost += paths.lost
    return shares, weights, lost
