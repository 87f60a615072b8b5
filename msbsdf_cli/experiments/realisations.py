"""Tracing light on realisations of an explicit surface for a scene."""

import time
from dataclasses import dataclass, replace

import numpy as np

from msbsdf_cli.experiments.discretisation import COARSER, pairs, squared_errors
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.run import Run
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene, direction
from msbsdf_cli.statistics.binning import MERGED, PHI_BINS, THETA_BINS, merge_bins
from msbsdf_cli.statistics.tally import Tally
from surfaces.facet import Array
from surfaces.free_path import next_heights
from surfaces.heightfield import all_waves, some_waves, synthesise
from surfaces.streams import stream
from surfaces.surface import Surface
from surfaces.tracing import Tracer

FREE_PATHS_OF_RAYS = 1 / 16
"""Free paths of a row for each ray of an incident angle."""


MOST_GROUPS = 16
"""Of surfaces: their scatter is known to a fifth then."""


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
    paired: bool = False
    """Whether to trace the same rays on a coarser mesh of the same field as well."""


@dataclass
class SurfaceResult:
    """One unit for each incident angle, free paths, and what it took."""

    tallies: list[Tally]
    coarser: list[Tally]
    """What the coarser mesh has more, for each incident angle; none where it was not traced."""
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
    wanted: FreePaths,
    seed: int,
    workers: Workers,
    max_order: int,
    quiet: bool,
) -> Run:
    """`samples` rays for each incident angle, spread over the realisations, and free paths of the
    directions and heights of `wanted`.

    The numbers depend on `seed` and not on `workers`.
    """
    started, free_paths = time.monotonic(), wanted.empty()
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
            paired=number < pairs(resolution.realisations),
        )
        for number in range(resolution.realisations)
    )
    tallies, coarser = ([Tally(scene.orders) for _ in scene.theta] for _ in range(2))
    groups = LobeGroups(scene, resolution.realisations)
    notes = dict.fromkeys(("embree_s", "surface_s", "trace_s", "rays", "free_paths_lost"), 0.0)
    total = rays * resolution.realisations * len(scene.theta)
    with Progress("simulate", total, "rays", quiet) as progress:
        for result in map_ordered(trace_surface, jobs, workers):
            for tally, unit in zip(tallies, result.tallies, strict=True):
                tally.merge(unit)
            groups.add(result.tallies)
            for more, unit in zip(coarser, result.coarser, strict=False):
                more.merge(unit)
            free_paths.add_unit(result.free_paths, result.free_path_weights, result.free_path_rays)
            for name in notes:
                notes[name] += getattr(result, name)
            progress.advance(rays * len(scene.theta))
    for tally, more in zip(tallies, coarser, strict=True):
        tally.systematic = squared_errors(tally, more, resolution.extent)
    wall_s = time.monotonic() - started
    light = tallies, free_paths, "gaussian", groups.lobes()
    return Run("simulate", scene, *light, wall_s, notes)


class LobeGroups:
    """Lobes of independent groups of surfaces, from which the scatter of anything that is made of
    lobes can be told: bins of one surface are not independent."""

    def __init__(self, scene: Scene, realisations: int) -> None:
        self.groups = min(MOST_GROUPS, realisations)
        bins = THETA_BINS * PHI_BINS // MERGED**2
        shape = len(scene.theta), self.groups, scene.orders + 1, 2, bins
        self.sums = np.zeros(shape)
        self.units = 0

    def add(self, units: list[Tally]) -> None:
        """The next surface's light, a unit for each incident angle."""
        group = self.units % self.groups
        for sums, unit in zip(self.sums[:, group], units, strict=True):
            lobe = unit.views(unit.sums[0])["lobe"]
            for place in np.ndindex(lobe.shape[:2]):
                sums[place] += merge_bins(lobe[place].reshape(THETA_BINS, PHI_BINS)).ravel()
        self.units += 1

    def lobes(self) -> Array:
        """Means of the groups, which share the surfaces evenly or nearly so; in single precision,
        as they are saved."""
        each = np.bincount(np.arange(self.units) % self.groups, minlength=self.groups)
        return np.asarray(self.sums / each[:, None, None, None], np.float32)


def trace_surface(job: SurfaceJob) -> SurfaceResult:
    """Make one surface and trace all incident angles and free paths on it."""
    started = time.perf_counter()
    scene = job.scene
    surface = realisation(job.resolution, job.number, job.seed)
    surface.query(np.zeros((3, 1)), np.ones((3, 1)))  # Embree builds in its first call.
    ready = time.perf_counter()
    surface.rays, surface.embree_s = 0, 0.0
    tracer = Tracer(surface, surface.stretch(*scene.alpha, scene.phi), scene.material)
    units = _units(job, tracer)
    traced = time.perf_counter()
    rays, embree_s = surface.rays, surface.embree_s
    n = max(round(job.rays * FREE_PATHS_OF_RAYS), 1)
    shares, weights, lost = _free_paths(job, tracer, n)
    coarser = _coarser(job, units) if job.paired else []
    return SurfaceResult(
        units, coarser, shares, weights, n, rays, embree_s, ready - started, traced - ready, lost
    )


def _units(job: SurfaceJob, tracer: Tracer) -> list[Tally]:
    """Light of all incident angles on one surface, as one unit for each."""
    units = []
    for i, theta in enumerate(job.scene.theta):
        rng = stream(job.seed, "rays", job.number, i)
        tally = Tally(job.scene.orders, independent=False)
        for light in tracer.trace(job.scene.wi(theta), job.rays, rng, job.max_order):
            tally.add(light)
        units.append(tally.as_unit())
    return units


def _coarser(job: SurfaceJob, units: list[Tally]) -> list[Tally]:
    """What the same rays on a coarser mesh of the same field give more than `units`."""
    scene, resolution = job.scene, job.resolution
    coarser = replace(resolution, cells=resolution.cells // COARSER)
    surface = realisation(coarser, job.number, job.seed)
    tracer = Tracer(surface, surface.stretch(*scene.alpha, scene.phi), scene.material)
    return [c.less(unit) for c, unit in zip(_units(job, tracer), units, strict=True)]


def _free_paths(job: SurfaceJob, tracer: Tracer, n: int) -> tuple[Array, Array, int]:
    """Shares (theta, starts, bins + 1), weights (theta, starts), and rays lost."""
    rng = stream(job.seed, "free-path rays", job.number)
    edges = np.array(job.free_path_edges)
    rows = len(job.free_path_theta), len(job.free_path_starts)
    shares, weights, lost = np.zeros((*rows, edges.size)), np.zeros(rows), 0
    for i, theta in enumerate(job.free_path_theta):
        d = direction(theta, job.scene.phi)
        for j, start in enumerate(job.free_path_starts):
            paths = next_heights(tracer.surface, tracer.stretch, d, start, n, rng)
            shares[i, j, :-1] = np.histogram(paths.heights, edges)[0]
            shares[i, j, -1] = paths.escaped
            shares[i, j] /= max(paths.heights.size + paths.escaped, 1)
            weights[i, j] = paths.weight
            lost += paths.lost
    return shares, weights, lost
