"""Free paths: their density, a surface on which they are traced, and the two side by side."""

import numpy as np

from msbsdf_cli.experiments.figures.settings import Settings, Tables
from msbsdf_cli.experiments.random_surfaces import Resolution, realisation
from msbsdf_cli.experiments.realisations import simulate
from msbsdf_cli.experiments.resolution import plan
from msbsdf_cli.experiments.walks import smith_shares, walk_free_paths
from msbsdf_cli.results.files import Table, from_rows
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.scene import Scene, direction
from msbsdf_cli.smith.heights import Gaussian
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.facet import Array
from surfaces.materials import Conductor
from surfaces.streams import stream

SCENE = Scene(Conductor(), Beckmann(1.0, 1.0), (0.0,))
HEIGHTS = Gaussian()

COLUMNS = (
    *("source", "theta_r_rad", "height_start", "height_low", "height_high", "probability"),
    "stderr",
)


def heitz_8(settings: Settings) -> Tables:
    """Probabilities of Eq. 28 in bins of height, and as the walk draws them."""
    paths = FreePaths((0.5, 1.2, 2.0), (-1.0, 0.0, 1.0), HEIGHTS.edges)
    rows = []
    for theta in paths.theta:
        for start in paths.starts:
            exact = free_path_density(theta, start)
            rows += _rows("model", theta, start, exact, np.zeros_like(exact))
    _walk(paths, settings.pick(1 << 18, 1 << 22), settings.seed)
    return {"heitz_8": _table([*rows, *_of("walk", paths)])}


def free_path_density(theta: float, start: float) -> Array:
    """Probabilities (bins + 1,) of the next facet's height from `start`, last of escape: [HHdD16]
    Eqs. 25 and 28, with t = -ln C1."""
    d = direction(theta)
    t = np.append(HEIGHTS.t(HEIGHTS.edges[:-1]), 0.0)
    t0, sigma = HEIGHTS.t(start), float(SCENE.slopes.sigma(d[:, None])[0])
    passed = np.maximum((t0 - t) / d[2], 0)
    with np.errstate(invalid="ignore"):
        survives = np.exp(-passed * sigma)
    if d[2] > 0:
        return np.append(-np.diff(survives), survives[-1])
    return np.append(np.diff(survives), 0.0)


def heitz_14(settings: Settings) -> Tables:
    """Free paths on explicit surfaces and of the Smith model, as `msbsdf compare --alpha 1`."""
    traced, model = traced_and_modelled(settings)
    return {"heitz_14": _table([*_of("surfaces", traced), *_of("walk", model)])}


def traced_and_modelled(settings: Settings) -> tuple[FreePaths, FreePaths]:
    """Free paths of Figure 14, from all heights of start."""
    wanted = FreePaths((0.5, 1.0, 1.4, 2.0), HEIGHTS.starts, HEIGHTS.edges)
    accuracy, rays = settings.pick((0.01, 200_000), (0.004, 1_000_000))
    resolution = plan(SCENE, accuracy, None, None, None, None)
    around = settings.seed, settings.workers, 10_000, settings.quiet
    run = simulate(SCENE, rays, resolution, wanted, *around)
    model = wanted.empty()
    _walk(model, rays, settings.seed)
    return run.free_paths, model


def heitz_13(settings: Settings) -> Tables:
    """Heights of a square of a random surface of roughness 1, in standard deviations of height."""
    made = Resolution(32, 12, 1)
    every, cells = settings.pick(4, 2), round(SIDE * made.cells / 2)
    heights = realisation(made, 0, settings.seed).heights[:cells:every, :cells:every]
    # A cell is so much of 2 / alpha.
    x = np.arange(len(heights)) * every * 2 / made.cells
    columns = (a.ravel() for a in (*np.meshgrid(x, x, indexing="ij"), heights))
    return {"heitz_13": dict(zip(("x", "y", "height"), (c.tolist() for c in columns), strict=True))}


SIDE = 16.0
"""Of the square that is shown: eight correlation lengths."""


def _walk(paths: FreePaths, samples: int, seed: int) -> None:
    draw = smith_shares(SCENE.slopes, HEIGHTS, paths.edges)
    walk_free_paths(draw, 0.0, paths, samples, stream(seed, "walk free paths"))


def _of(source: str, paths: FreePaths) -> list[tuple[str | float, ...]]:
    return [
        row
        for (theta, start), found in paths.rows().items()
        for row in _rows(source, theta, start, found.value, found.stderr)
    ]


def _rows(
    source: str, theta: float, start: float, value: Array, stderr: Array
) -> list[tuple[str | float, ...]]:
    low = [*HEIGHTS.edges[:-1].tolist(), np.inf]
    high = [*HEIGHTS.edges[1:].tolist(), np.inf]
    bins = zip(low, high, value.tolist(), stderr.tolist(), strict=True)
    return [(source, theta, start, *cells) for cells in bins]


def _table(rows: list[tuple[str | float, ...]]) -> Table:
    return from_rows(COLUMNS, rows)
