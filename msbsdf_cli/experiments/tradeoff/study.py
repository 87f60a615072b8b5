"""The whole study: reference, methods, surfaces, and what follows from them."""

from dataclasses import dataclass, field, replace

from msbsdf_cli.experiments.random_surfaces import Resolution
from msbsdf_cli.experiments.tradeoff.counted import count, counted_rows
from msbsdf_cli.experiments.tradeoff.directions import Lobe, lobe_directions
from msbsdf_cli.experiments.tradeoff.energies import energy_rows
from msbsdf_cli.experiments.tradeoff.floors import MARGIN, Floor, floors, margin
from msbsdf_cli.experiments.tradeoff.measuring import Protocol, ladder, measure
from msbsdf_cli.experiments.tradeoff.reference import Reference, references
from msbsdf_cli.experiments.tradeoff.roughness import ALPHAS, roughness_rows
from msbsdf_cli.experiments.tradeoff.rows import (
    Row,
    against_surfaces,
    method_rows,
    simulate_rows,
    with_distances,
)
from msbsdf_cli.experiments.tradeoff.scaling import (
    REPEATS,
    Scaling,
    of_rows,
    one_each,
    over_orders,
    over_threads,
)
from msbsdf_cli.experiments.tradeoff.surface_reference import distances, trace_surfaces
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene

PAIRS = 8
"""Outgoing directions that are asked for one at a time."""
PAIR_REPLICATES = 6


@dataclass(frozen=True)
class Settings:
    """How much is measured."""

    methods: tuple[str, ...]
    samples: int
    """Walks of the dearest setting."""
    replicates: int
    """Independent repetitions of each setting."""
    directions: int
    """Outgoing directions of a lobe, about."""
    qmc: bool
    """Whether paths start from scrambled Sobol points."""
    resolution: Resolution | None
    """Of the surfaces; None: they are left out."""
    autocorrelation: str
    """Of the surfaces, also of those that methods remember."""
    against: str
    """What errors are against: `smith`, or `surfaces`."""
    rays: int
    """On the surfaces, for each incident angle."""
    seed: int
    threads: int
    """Most processes of the runs over their number; the others are timed on one."""
    quiet: bool

    def protocol(self, purpose: str, most: int | None = None) -> Protocol:
        """How often to run, at most `most` times."""
        few = self.replicates if most is None else min(self.replicates, most)
        return Protocol(few, self.seed, self.qmc, purpose)


@dataclass
class Result:
    """What the study found."""

    truth: Reference
    rows: list[Row]
    floors: list[Floor]
    margin: float
    """Errors that are judged over that of the reference, at least."""
    pairs: list[Row]
    scaling: list[Scaling]
    energies: list[Row]
    """Of simulations, by ever more surfaces."""
    warnings: list[str] = field(default_factory=list)


def study(scene: Scene, settings: Settings) -> Result:
    """Measure all methods against the Smith model solved, and that against surfaces."""
    seed, methods, of = settings.seed, settings.methods, settings.autocorrelation
    lobes = [lobe_directions(scene, theta, settings.directions, seed) for theta in scene.theta]
    pairs = [lobe_directions(scene, theta, PAIRS, seed) for theta in scene.theta]
    truth, pair_truth = references(scene, lobes, pairs, methods, settings.samples, seed)
    protocol = settings.protocol("chart")
    with Progress("methods", protocol.replicates + 1, "rounds", settings.quiet) as progress:
        steps = ladder(methods, settings.samples, of)
        series = measure(scene, steps, lobes, protocol, progress.advance)
    rows = method_rows(scene, series, truth)
    surfaces, found, energies = None, [], []
    if settings.resolution is not None:
        work = settings.rays, seed, settings.threads, settings.quiet
        surfaces = trace_surfaces(scene, settings.resolution, *work)
        found = distances(scene, methods, surfaces, seed, settings.threads, of)
        energies = energy_rows(scene, surfaces.steps, surfaces.spent, surfaces.rays)
        rows = [*rows, *simulate_rows(scene, surfaces)]
        if settings.against == "surfaces" and "walk-memory" in methods:
            counted = count(scene, of, seed)
            more, apart = counted_rows(scene, counted, surfaces)
            rows, found = [*rows, *more], [*found, *apart]
        rows = with_distances(rows, found)
    better = margin(rows, truth, scene.theta)
    if settings.against == "surfaces":
        rows = against_surfaces(rows, found)
    return Result(
        truth,
        rows,
        floors(scene, truth, surfaces, found),
        better,
        pair_rows(scene, pairs, pair_truth, settings),
        scale(scene, rows, lobes[len(lobes) // 2], settings),
        energies,
        [] if better >= MARGIN else [_too_near(truth, better)],
    )


def _too_near(truth: Reference, better: float) -> str:
    return (
        f"the reference, {truth.method}, is only {better:.2g} times better than "
        "the best setting it judges: the smallest errors are upper bounds."
    )


def pair_rows(scene: Scene, lobes: list[Lobe], truth: Reference, settings: Settings) -> list[Row]:
    """Rows of a renderer's case: one pair of directions at a time."""
    of = settings.autocorrelation
    each = one_each(settings.methods, settings.samples)
    steps = [replace(s, one_by_one=True, autocorrelation=of) for s in each]
    protocol = settings.protocol("pairs", PAIR_REPLICATES)
    with Progress("pairs", protocol.replicates + 1, "rounds", settings.quiet) as progress:
        series = measure(scene, steps, lobes, protocol, progress.advance)
    return method_rows(scene, series, truth)


def scale(scene: Scene, rows: list[Row], lobe: Lobe, settings: Settings) -> list[Scaling]:
    """Time over samples, orders, processes and roughness, at the angle of `lobe`."""
    methods = settings.methods
    dearest = [s for s in one_each(methods, settings.samples) if s.samples]
    protocol = settings.protocol("roughness")
    with Progress("roughness", len(ALPHAS), "roughnesses", settings.quiet) as progress:
        work = methods, (lobe.theta,), settings.directions, protocol
        rough = roughness_rows(scene, *work, progress.advance)
    return [
        *of_rows("samples", rows),
        *over_orders(scene, methods, lobe, Protocol(REPEATS, settings.seed, settings.qmc)),
        *over_threads(scene, dearest, lobe, settings.threads, settings.seed),
        *of_rows("roughness", rough),
    ]
