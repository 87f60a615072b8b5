"""Pictures of a scene by several methods: settings in, pictures out."""

import os
import time
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.experiments.render.lights import LUMINANCE
from msbsdf_cli.experiments.render.paths import Counts, Integrator, Shader
from msbsdf_cli.experiments.render.stage import Stage
from msbsdf_cli.experiments.render.tables import TABULATED, check_tabulated, tabulated
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.registry import METHODS
from msbsdf_cli.results.files import Table
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.walk import BLOCK
from surfaces.facet import Array
from surfaces.materials import Dielectric, Material
from surfaces.streams import stream

CHUNK = 1024
"""Pixels of a job."""


@dataclass(frozen=True)
class Settings:
    """How a picture is made."""

    width: int
    height: int
    samples: int
    """Paths for each pixel, at least 2."""
    seed: int = 0
    strategy: str = "mis"
    number: int = 0
    """Of the picture, among those of one run: each has paths of its own."""


@dataclass
class Picture:
    """Linear radiance by one method, (3, height, width)."""

    method: str
    mean: Array
    stderr: Array
    """From the scatter of the paths of each pixel."""
    samples: int
    seconds: float
    """Of processor time, for all paths."""
    surfaces: int
    """Surfaces that the paths met."""
    lost: int
    """Paths that rounding lost."""
    table_error: float = 0.0
    """Of a method that shades by a table: what that is off by, relative to its mean."""
    setup_seconds: float = 0.0
    """Of processor time, for tables that are made before the first path."""
    nonfinite: int = 0
    """Values that were not finite, which the method replaced or left out."""
    cut: int = 0
    """Walks that the method cut off at its largest number of facets."""

    @property
    def noise(self) -> float:
        """Root mean square standard error of luminance over its root mean square."""
        mean, stderr = (luminance(a) for a in (self.mean, self.stderr))
        return float(np.sqrt((stderr**2).mean() / (mean**2).mean()))


def luminance(image: Array) -> Array:
    """(height, width) of (3, height, width); of standard errors an upper bound, as if the channels
    of a path went together, which they do."""
    return np.tensordot(LUMINANCE, image, 1)


@dataclass(frozen=True)
class Job:
    """Some pixels of a picture."""

    stage: Stage
    shader: Shader
    settings: Settings
    method: str
    number: int


def shader(
    name: str,
    slopes: Slopes,
    material: Material,
    textured: bool,
    seed: int,
    workers: Workers,
    quiet: bool,
) -> Shader:
    """A method for both sides of a surface."""
    if name in TABULATED:
        return Shader(slopes, *tabulated(name, slopes, material, textured, seed, workers, quiet))
    kind = METHODS[name]
    inside = kind(slopes, Dielectric(1 / material.ior), 1) if material.transmits else None
    return Shader(slopes, kind(slopes, material, 1), inside)


def check_shades(name: str, slopes: Slopes, material: Material, texture: str = "none") -> None:
    """Raise UnsupportedError for a method that cannot shade pixels of this surface."""
    table = name in TABULATED
    if table:
        check_tabulated(name, slopes, material)
    else:
        METHODS[name].check_supported(slopes, material)
    if not table and not METHODS[name].traits.pairs:
        raise UnsupportedError(f"method {name} evaluates no pairs of directions, as pixels ask")
    if table and texture == "albedo":
        raise UnsupportedError(f"method {name} shades by a table, which has room for one albedo")
    two = slopes.alpha_x != slopes.alpha_y or texture == "anisotropy"
    if not table and texture in ("roughness", "anisotropy") and two:
        if METHODS[name].traits.one_roughness_textured:
            raise UnsupportedError(
                f"method {name} has tables for textures of one roughness, not of two"
            )
    elif table and texture == "anisotropy":
        raise UnsupportedError(f"method {name} shades by a table, which has room for one roughness")


def render(
    stage: Stage,
    slopes: Slopes,
    material: Material,
    methods: tuple[str, ...],
    settings: Settings,
    workers: Workers,
    quiet: bool,
) -> list[Picture]:
    """A picture by each method. Raises UnsupportedError for what a method cannot do."""
    of_all = stage.texture is not None, settings.seed, workers, quiet
    shaders, setup = {}, {}
    for name in methods:
        started = sum(os.times()[:4])
        shaders[name] = prepared(shader(name, slopes, material, *of_all), stage)
        setup[name] = sum(os.times()[:4]) - started
    chunks = -(-settings.width * settings.height // CHUNK)
    jobs = [Job(stage, shaders[name], settings, name, k) for name in methods for k in range(chunks)]
    parts: dict[str, list[Part]] = {name: [] for name in methods}
    with Progress("render", len(jobs) * CHUNK * settings.samples, "paths", quiet) as progress:
        for job, part in zip(jobs, map_ordered(run_job, jobs, workers), strict=True):
            parts[job.method].append(part)
            progress.advance(CHUNK * settings.samples)
    return [
        _picture(name, settings, of, shaders[name].error, setup[name]) for name, of in parts.items()
    ]


def table_of(pictures: list[Picture]) -> Table:
    """render.csv: a row for each method; differences are from the first."""
    names = (
        *("method", "samples", "seconds", "surfaces_per_path", "lost", "luminance"),
        *("luminance_stderr", "noise", "variance", "difference", "difference_stderr"),
        *("table_error", "setup_seconds", "nonfinite", "cut"),
    )
    table: dict[str, list[float | str]] = {name: [] for name in names}
    first = pictures[0]
    for p in pictures:
        pixels = p.mean[0].size
        mean, stderr = luminance(p.mean), luminance(p.stderr)
        of_all = np.sqrt((stderr**2).sum()) / pixels
        apart = luminance(p.mean - first.mean).mean() if p is not first else 0.0
        both = np.hypot(of_all, np.sqrt((luminance(first.stderr) ** 2).sum()) / pixels)
        cells = (
            *(p.method, p.samples, p.seconds, p.surfaces / (pixels * p.samples), p.lost),
            *(mean.mean(), of_all, p.noise, p.samples * (stderr**2).mean()),
            *(apart, both if p is not first else 0.0, p.table_error, p.setup_seconds),
            *(p.nonfinite, p.cut),
        )
        for column, cell in zip(table.values(), cells, strict=True):
            column.append(cell if isinstance(cell, str) else float(cell))
    return table


def prepared(of: Shader, stage: Stage) -> Shader:
    """The same with the tables that a texture needs made once, and not in every process."""
    if stage.texture is not None:
        for method in (of.outside, of.inside):
            if method is not None:
                point = np.zeros((3, 1))
                method.of_lanes(*stage.lanes(of.slopes, method.material, point))
    return of


@dataclass(frozen=True)
class Part:
    """Sums over the paths of some pixels, (3, n)."""

    sums: Array
    squares: Array
    seconds: float
    counts: Counts


def run_job(job: Job) -> Part:
    """Follow the paths of some pixels."""
    settings = job.settings
    # The tree is made once in each process, and is no part of what a path costs.
    _ = job.stage.body.scene
    started = time.process_time()
    total = settings.width * settings.height
    pixels = np.arange(job.number * CHUNK, min((job.number + 1) * CHUNK, total))
    place = job.method, settings.strategy, job.number, settings.number
    rng = stream(settings.seed, "render", *place)
    integrator = Integrator(job.stage, job.shader, settings.strategy)
    sums = np.zeros((2, 3, pixels.size))
    most = max(1, BLOCK // pixels.size)
    for first in range(0, settings.samples, most):
        several = min(most, settings.samples - first)
        places = np.tile(pixels, several)
        x, y = places % settings.width, places // settings.width
        shift = rng.random((2, places.size))
        camera = job.stage.camera
        d = camera.rays((x + shift[0]) / settings.width, (y + shift[1]) / settings.height)
        o = np.tile(np.array(camera.eye)[:, None], places.size)
        found = integrator.radiance(o, d, rng).reshape(3, several, pixels.size)
        sums[0] += found.sum(axis=1)
        sums[1] += np.einsum("csp,csp->cp", found, found)
    return Part(sums[0], sums[1], time.process_time() - started, integrator.counts)


def _picture(
    name: str, settings: Settings, parts: list[Part], error: float, setup: float
) -> Picture:
    n, shape = settings.samples, (3, settings.height, settings.width)
    mean = np.concatenate([part.sums for part in parts], axis=1) / n
    squares = np.concatenate([part.squares for part in parts], axis=1) / n
    stderr = np.sqrt(np.maximum(squares - mean * mean, 0) / (n - 1))
    return Picture(
        name,
        mean.reshape(shape),
        stderr.reshape(shape),
        n,
        sum(part.seconds for part in parts),
        sum(part.counts.surfaces for part in parts),
        sum(part.counts.lost for part in parts),
        error,
        setup,
        sum(part.counts.nonfinite for part in parts),
        sum(part.counts.cut for part in parts),
    )
