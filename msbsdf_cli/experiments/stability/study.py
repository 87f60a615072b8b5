"""The map: all methods and precisions at all points."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from msbsdf_cli.experiments.stability import verdicts
from msbsdf_cli.experiments.stability.points import ALPHA, ORDERS, THETA, UNIFORM, Point
from msbsdf_cli.experiments.stability.probes import Figures, measure, seconds
from msbsdf_cli.experiments.stability.truth import LONG_WALKS, MANY_LONGER, MOST_FACETS, Truth
from msbsdf_cli.methods.protocol import Method, UnsupportedError
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.methods.solver.size import value_seconds
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Slopes
from surfaces.materials import Material

PRECISIONS = {"float64": np.float64, "float32": np.float32}

PATIENCE_S, PATIENCE_OF_DRAFT_S = 7.0, 1.6
"""Seconds beyond which `solve`, which says beforehand how long it takes, is not asked for a
cell."""


@dataclass(frozen=True)
class Row:
    """One cell of stability.csv."""

    method: str
    precision: str
    parameter: str
    value: float | str
    material: str
    slopes: str
    alpha_x: float
    alpha_y: float
    theta_i_rad: float
    verdict: str
    nonfinite: int
    energy_error: float
    bounces_mean: float
    slowdown: float
    note: str
    phi_i_rad: float
    ior: float
    absorptance: float
    energy_stderr: float
    chi_square_p: float
    tail_index: float
    unresolved: float
    cell: str


@dataclass(frozen=True)
class Job:
    """All methods at one point."""

    point: Point
    methods: tuple[str, ...]
    precisions: tuple[str, ...]
    seed: int
    draft: bool

    @property
    def name(self) -> str:
        """As the name of a piece of the map."""
        return ",".join((*self.point.place, *self.methods, *self.precisions, str(self.draft)))


def study(
    points: list[Point],
    methods: tuple[str, ...],
    precisions: tuple[str, ...],
    draft: bool,
    seed: int,
    workers: Workers,
    quiet: bool,
    done: dict[str, list[dict[str, Any]]],
    keep: Callable[[str, list[dict[str, Any]]], None],
) -> list[Row]:
    """All cells. Pieces in `done` are taken as they are; `keep` gets each new one."""
    jobs = [Job(point, methods, precisions, seed, draft) for point in points]
    todo = [job for job in jobs if job.name not in done]
    found = dict(done)
    with Progress("stability", max(len(todo), 1), "points", quiet) as progress:
        for job, rows in zip(todo, map_ordered(run, todo, workers), strict=True):
            found[job.name] = [asdict(row) for row in rows]
            keep(job.name, found[job.name])
            progress.advance(1)
    return [Row(**row) for job in jobs for row in found[job.name]]


def run(job: Job) -> list[Row]:
    """The rows of one point."""
    truth = Truth(job.point, job.seed)
    rows = []
    for name in job.methods:
        scene = job.point.scene
        if job.point.parameter == UNIFORM and METHODS[name].deterministic:
            continue
        try:
            METHODS[name].check_supported(scene.slopes, scene.material)
            method, verdict = _affordable(name, scene, job.draft)
        except (UnsupportedError, ArithmeticError) as refusal:
            rows += [_row(job, p, name, verdicts.REFUSED, f"{refusal}") for p in job.precisions]
            continue
        if isinstance(method, str):
            rows += [_row(job, p, name, verdict, method) for p in job.precisions]
            continue
        cells: list[tuple[Row, Figures | None]] = []
        for precision in job.precisions:
            # `solve` computes in double precision whatever comes in: once is enough.
            known = cells[0][1] if cells and not method.traits.samples else None
            cells.append(_measured(job, precision, method, truth, known))
        rows += [row for row, _ in cells[:1]]
        rows += [_beside(row, figures, cells[0]) for row, figures in cells[1:]]
    return rows


def _beside(row: Row, figures: Figures | None, first: tuple[Row, Figures | None]) -> Row:
    """The row, told where its energies are not those of the first precision's."""
    other = first[1]
    if figures is None or other is None or row.verdict not in (verdicts.WORKS, verdicts.UNKNOWN):
        return row
    apart = verdicts.apart(figures, other)
    if apart is None:
        return row
    return replace(row, verdict=verdicts.DEGRADED, note=f"{apart} with {first[0].precision}")


def _affordable(name: str, scene: Scene, draft: bool) -> tuple[Method | str, str]:
    """The method, or a sentence on why a cell is not worth its time, and then its verdict."""
    if name == Solve.name:
        takes = value_seconds(scene.slopes, scene.material)
        text = f"takes about {takes:.0f} s by its own estimate, and was not run"
        if takes > PATIENCE_S:
            return text, verdicts.DEGRADED
        if draft and takes > PATIENCE_OF_DRAFT_S:
            return f"{text} for a draft", verdicts.UNKNOWN
    method: Method = METHODS[name](scene.slopes, scene.material, ORDERS)
    return method, ""


def _measured(
    job: Job, precision: str, method: Method, truth: Truth, known: Figures | None
) -> tuple[Row, Figures | None]:
    """One cell, with what it costs beside the same method at ordinary roughness, and what was
    measured, if anything was; `known` is taken for it where it is there."""
    dtype = PRECISIONS[precision if method.traits.samples else "float64"]
    mean = truth.bounces
    if not method.deterministic and (mean > LONG_WALKS or truth.longer > MANY_LONGER):
        longer = f", {truth.longer:.1%} of them more than {MOST_FACETS}" if truth.longer else ""
        note = f"walks hit {mean:.0f} facets{longer}; not measured"
        row = _row(job, precision, method.name, verdicts.DEGRADED, note, bounces_mean=mean)
        return row, None
    try:
        figures = known or measure(method, truth, dtype, job.seed)
    except ArithmeticError as refusal:
        return _row(job, precision, method.name, verdicts.REFUSED, f"{refusal}"), None
    scene = job.point.scene
    kinds = type(scene.slopes), type(scene.material)
    ordinary = _ordinary_seconds(
        method.name,
        precision if method.traits.samples else "float64",
        *kinds,
        figures.walks,
        job.seed,
    )
    took = figures.seconds
    if method.traits.samples:
        took = seconds(method, truth, dtype, figures.walks, job.seed)
    slowdown = took / ordinary
    verdict, reasons, error = verdicts.judge(
        figures, truth, method.traits, method.deterministic, slowdown
    )
    assert figures.stderr is not None
    row = _row(
        job,
        precision,
        method.name,
        verdict,
        "; ".join(reasons),
        nonfinite=figures.nonfinite,
        energy_error=float(error),
        bounces_mean=float("nan") if method.deterministic else truth.bounces,
        slowdown=slowdown,
        energy_stderr=float(figures.stderr.sum()),
        chi_square_p=figures.chi_square_p,
        tail_index=figures.tail_index,
        unresolved=figures.unresolved,
    )
    return row, figures


@lru_cache(maxsize=256)
def _ordinary_seconds(
    name: str,
    precision: str,
    slopes: type[Slopes],
    material: type[Material],
    walks: int,
    seed: int,
) -> float:
    """Seconds of the same evaluation at ordinary roughness and incidence."""
    scene = Scene(material(), slopes(ALPHA, ALPHA), (THETA,), 0.3, ORDERS)
    point = Point("ordinary", 0.0, scene)
    method: Method = METHODS[name](scene.slopes, scene.material, ORDERS)
    truth = Truth(point, seed)
    if not method.traits.samples:
        return measure(method, truth, PRECISIONS[precision], seed).seconds
    return seconds(method, truth, PRECISIONS[precision], walks, seed)


def _row(job: Job, precision: str, name: str, verdict: str, note: str, **figures: Any) -> Row:
    point, scene = job.point, job.point.scene
    none = float("nan")
    material = scene.material
    absorptance = 1 - float(np.mean(material.albedos))
    if material.specular and material.absorbs:
        absorptance = 1 - float(material.reflectance(np.ones(1))[0, 0])
    settings: dict[str, Any] = {
        "nonfinite": 0,
        "energy_error": none,
        "bounces_mean": none,
        "slowdown": none,
        "energy_stderr": none,
        "chi_square_p": none,
        "tail_index": none,
        "unresolved": none,
    }
    return Row(
        method=name,
        precision=precision,
        parameter=point.parameter,
        value=point.value,
        material=material.name,
        slopes=scene.slopes.name,
        alpha_x=scene.alpha[0],
        alpha_y=scene.alpha[1],
        theta_i_rad=point.theta,
        phi_i_rad=scene.phi,
        ior=material.ior if material.transmits else none,
        absorptance=absorptance,
        verdict=verdict,
        note=note,
        cell=",".join((name, precision, *point.place)),
        **settings | figures,
    )
