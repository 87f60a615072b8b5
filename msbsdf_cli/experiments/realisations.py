"""Tracing light on realisations of an explicit surface for a scene."""

import time
from dataclasses import dataclass, replace

import numpy as np

from msbsdf_cli.experiments.control_variates import NUMBER, controls, expected
from msbsdf_cli.experiments.random_surfaces import (
    Resolution,
    counted,
    facet_slopes,
    realisation,
)
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.results.run import Run
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene, direction
from msbsdf_cli.statistics.binning import MERGED, PHI_BINS, THETA_BINS, merge_bins
from msbsdf_cli.statistics.discretisation import extrapolated, meshes, on_all_meshes
from msbsdf_cli.statistics.surface_tally import SurfaceLight, SurfaceTally
from msbsdf_cli.statistics.tally import Tally
from surfaces.facet import Array
from surfaces.free_path import FreePathTracer
from surfaces.marginal import marginal
from surfaces.streams import stream
from surfaces.surface import Surface
from surfaces.tracing import Tracer
from surfaces.views import UPRIGHT, VIEWS

FREE_PATHS_OF_RAYS = 1 / 16
"""Free paths of a row for each ray of an incident angle."""


RAYS_OF_SHARED = 4
"""Rays of a surface for each that is traced on coarser meshes too: few are enough, as little noise
is left between two meshes of one field."""

MOST_GROUPS = 16
"""Of surfaces: their scatter is known to a fifth then."""


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
    expected: tuple[Array, ...]
    """Expected control variates (3,) of each incident angle."""
    on_all_meshes: bool = False
    """Whether to trace the same rays on two coarser meshes of the same field as well."""
    place: int = 0
    """Where the scene's rays begin among all that meet this surface, as scenes of a sweep do."""


@dataclass
class SurfaceResult:
    """The light of each incident angle, free paths, and what it took."""

    light: list[SurfaceLight]
    free_paths: Array
    free_path_weights: Array
    free_path_rays: int
    """Free paths of each row."""
    coarser_free_paths: tuple[Array, Array] | None
    """Shares and weights on a mesh of half the cells, if light was traced there too."""
    rays: int
    """Rays asked of Embree for the incident light."""
    embree_s: float
    surface_s: float
    """Seconds for making the surface and its Embree scene."""
    trace_s: float
    coarser_s: float
    """Seconds for coarser meshes and tracing on them."""
    free_paths_lost: int

    @property
    def paths(self) -> tuple[Array, Array, int, tuple[Array, Array] | None]:
        """A unit for `FreePaths.add_unit`."""
        shares = self.free_paths, self.free_path_weights
        return *shares, self.free_path_rays, self.coarser_free_paths


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

    The numbers depend on `seed` and not on `workers`. The surface has the roughness of
    `scene.slopes`, which are Beckmann's. Where heights are not Gaussian its slopes are not: the
    scene of the run has them as they were counted on the facets.
    """
    started, free_paths = time.monotonic(), wanted.empty()
    rays = -(-samples // resolution.realisations)
    heights_are = marginal(resolution.heights_of)
    known = tuple(expected(scene.slopes, scene.wi(t), heights_are) for t in scene.theta)
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
            known,
            on_all_meshes=number < on_all_meshes(resolution.realisations),
        )
        for number in range(resolution.realisations)
    )
    tallies = [SurfaceTally(scene.orders, NUMBER, resolution.lengths) for _ in scene.theta]
    groups = LobeGroups(scene, resolution.realisations)
    notes = dict.fromkeys(("embree_s", "surface_s", "trace_s", "rays", "free_paths_lost"), 0.0)
    total = rays * resolution.realisations * len(scene.theta)
    with Progress("simulate", total, "rays", quiet) as progress:
        for number, result in enumerate(map_ordered(trace_surface, jobs, workers)):
            for tally, light in zip(tallies, result.light, strict=True):
                tally.add_surface(light)
            groups.add([light.unit for light in result.light], number)
            free_paths.add_unit(*result.paths)
            for name in notes:
                notes[name] += getattr(result, name)
            progress.advance(rays * len(scene.theta))
    wall_s = time.monotonic() - started
    if resolution.skewed:
        scene = replace(scene, slopes=counted(facet_slopes(scene, resolution, seed), scene.alpha))
    what = list[Tally](tallies), free_paths, resolution.heights_of, groups.lobes()
    return Run("simulate", scene, *what, wall_s, notes, groups.units)


class LobeGroups:
    """Lobes of independent groups of surfaces, from which the scatter of anything that is made of
    lobes can be told: bins of one surface are not independent."""

    def __init__(self, scene: Scene, realisations: int) -> None:
        self.groups = min(MOST_GROUPS, realisations)
        bins = THETA_BINS * PHI_BINS // MERGED**2
        shape = len(scene.theta), self.groups, scene.orders + 1, 2, bins
        self.sums = np.zeros(shape)
        self.units = np.zeros(self.groups, int)
        """Surfaces of each group."""

    def add(self, units: list[Tally], number: int) -> None:
        """The light of surface `number`, a unit for each incident angle."""
        group = number % self.groups
        for sums, unit in zip(self.sums[:, group], units, strict=True):
            lobe = unit.views(unit.sums[0])["lobe"]
            for place in np.ndindex(lobe.shape[:2]):
                sums[place] += merge_bins(lobe[place].reshape(THETA_BINS, PHI_BINS)).ravel()
        self.units[group] += 1

    def lobes(self) -> Array:
        """Means of the groups, which share the surfaces evenly or nearly so; in single precision,
        as they are saved."""
        return np.asarray(self.sums / self.units[:, None, None, None], np.float32)


class Meshes:
    """One realisation of the surface in several finenesses, each made when it is first wanted."""

    def __init__(self, resolution: Resolution, number: int, seed: int) -> None:
        self.field = resolution, number, seed
        self.made: dict[int, Surface] = {}

    def surface(self, cells: int) -> Surface:
        """The surface with so many cells a unit of length, and its Embree scene."""
        if cells not in self.made:
            resolution, number, seed = self.field
            self.made[cells] = realisation(replace(resolution, cells=cells), number, seed)
            self.made[cells].build()
        return self.made[cells]


def trace_surface(job: SurfaceJob, fields: Meshes | None = None) -> SurfaceResult:
    """Make one surface, unless there are its meshes, and trace all incident angles and free paths
    on it."""
    started = time.perf_counter()
    scene = job.scene
    fields = fields or Meshes(job.resolution, job.number, job.seed)
    surface = fields.surface(job.resolution.cells)
    ready = time.perf_counter()
    tracer = _tracer(job, surface)
    shared = _shared_rays(job)
    units = _units(job, tracer, (shared, job.rays - shared))
    traced = time.perf_counter()
    rays, embree_s = surface.rays, surface.embree_s
    n = max(round(job.rays * FREE_PATHS_OF_RAYS), 1)
    shares, weights, lost = _free_paths(job, tracer, n)
    light = [
        SurfaceLight(unit, controls(surface, tracer.views, scene.wi(theta)) - known)
        for (_, unit), theta, known in zip(units, scene.theta, job.expected, strict=True)
    ]
    coarser = time.perf_counter()
    on_half = None
    if job.on_all_meshes:
        _add_coarser(job, fields, light, [unit for unit, _ in units])
        on_half = _free_paths_on_half(job, fields, n)
    seconds = ready - started, traced - ready, time.perf_counter() - coarser
    return SurfaceResult(light, shares, weights, n, on_half, rays, embree_s, *seconds, lost)


def _tracer(job: SurfaceJob, surface: Surface) -> Tracer:
    stretch = surface.stretch(*job.scene.alpha, job.scene.phi)
    # Skewed heights are others upside down.
    views = UPRIGHT if job.resolution.skewed else VIEWS
    return Tracer(surface, stretch, job.scene.material, views)


def _shared_rays(job: SurfaceJob) -> int:
    """How many rays are traced on the coarser meshes as well."""
    return -(-job.rays // RAYS_OF_SHARED) if job.on_all_meshes else job.rays


def _units(job: SurfaceJob, tracer: Tracer, parts: tuple[int, ...]) -> list[list[Tally]]:
    """Light of each incident angle on one surface, as units: of the first part of the rays, of the
    first and the second, ..."""
    units = []
    for i, theta in enumerate(job.scene.theta):
        rng = stream(job.seed, "rays", job.number, job.place + i)
        tally, found = Tally(job.scene.orders, independent=False), []
        for rays in parts:
            for light in tracer.trace(job.scene.wi(theta), rays, rng, job.max_order):
                tally.add(light)
            found.append(tally.as_unit())
        units.append(found)
    return units


def _add_coarser(
    job: SurfaceJob, fields: Meshes, light: list[SurfaceLight], fine: list[Tally]
) -> None:
    """What the rays of `fine` tell on the two coarser meshes of the same field."""
    cells = job.resolution.cells
    fewer = meshes(cells, job.resolution.extent)
    coarser = []
    for some in fewer:
        coarser.append(_units(job, _tracer(job, fields.surface(some)), (_shared_rays(job),)))
    for mine, unit, (middle,), (coarse,) in zip(light, fine, *coarser, strict=True):
        mine.more, mine.doubt = extrapolated((cells, *fewer), unit, middle, coarse)


def _free_paths_on_half(job: SurfaceJob, fields: Meshes, n: int) -> tuple[Array, Array] | None:
    """Shares and weights on a mesh of half the cells; None where none is coarser."""
    half, _ = meshes(job.resolution.cells, job.resolution.extent)
    if half == job.resolution.cells:
        return None
    shares, weights, _ = _free_paths(job, _tracer(job, fields.surface(half)), n)
    return shares, weights


def _free_paths(job: SurfaceJob, tracer: Tracer, n: int) -> tuple[Array, Array, int]:
    """Shares (theta, starts, bins + 1), weights (theta, starts), and rays lost."""
    rng = stream(job.seed, "free-path rays", job.number, job.place)
    edges = np.array(job.free_path_edges)
    rows = len(job.free_path_theta), len(job.free_path_starts)
    shares, weights, lost = np.zeros((*rows, edges.size)), np.zeros(rows), 0
    paths_of = FreePathTracer(tracer.surface, tracer.views).next_heights
    for i, theta in enumerate(job.free_path_theta):
        d = direction(theta, job.scene.phi)
        for j, start in enumerate(job.free_path_starts):
            paths = paths_of(d, start, n, rng)
            shares[i, j, :-1] = np.histogram(paths.heights, edges, weights=paths.shares)[0]
            shares[i, j, -1] = paths.escaped
            # Without those that were lost.
            shares[i, j] /= (paths.shares.sum() + paths.escaped) or 1
            weights[i, j] = paths.weight
            lost += paths.lost
    return shares, weights, lost
