"""How tables for pictures are made: of `solve`, and of light traced on explicit surfaces."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import trapezoid

from msbsdf_cli.experiments.realisations import simulate
from msbsdf_cli.experiments.render.solved import solved_table
from msbsdf_cli.experiments.render.tabulated import Adds, Table, Tabulated
from msbsdf_cli.experiments.resolution import plan
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.single import Single
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.renderers.tables import check, other_side
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.run.executors import Workers
from msbsdf_cli.scene import Scene
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, lobe_axes, lobe_bin
from surfaces.facet import Array
from surfaces.materials import Conductor, Material
from surfaces.streams import stream

SURFACES = "surfaces"
"""The name under which light traced on surfaces shades pictures."""
TABULATED = (Solve.name, SURFACES)
"""What shades by a table."""

LEVELS = 9
"""Roughnesses of a textured table, evenly spaced from 0 on."""

THETA_OF_SURFACES = (0.0, 0.3, 0.6, 0.85, 1.05, 1.2, 1.32, 1.42, 1.5, 1.55)
"""Incident polar angles that are traced, in radians."""
RAYS = 1_000_000
"""For each of them."""
ACCURACY = 2e-3
"""Of an order's energy, which decides how the surfaces are made."""
SAMPLES_OF_SINGLE = 1_000_000


def check_tabulated(name: str, slopes: Slopes, material: Material) -> None:
    """Raise UnsupportedError for a surface of which no table is made."""
    if slopes.alpha_x != slopes.alpha_y:
        raise UnsupportedError(f"method {name} shades by a table, which has room for one roughness")
    if name == SURFACES and slopes.name != "beckmann":
        raise UnsupportedError(
            f"the slopes of explicit surfaces are Gaussian, --slopes beckmann, not {slopes.name}"
        )
    if name != SURFACES:
        check(slopes, material)


def tabulated(
    name: str,
    slopes: Slopes,
    material: Material,
    textured: bool,
    seed: int,
    workers: Workers,
    quiet: bool,
) -> tuple[Tabulated, Tabulated | None]:
    """`solve` or the surfaces as a table, if textured for all roughnesses up to that of `slopes`;
    and another for light from inside, if it goes there. Raises UnsupportedError for what no table
    is made of."""
    check_tabulated(name, slopes, material)
    top = slopes.alpha_x
    alphas = np.linspace(0, top, LEVELS)[1:] if textured else np.array([top])
    rough = [replace(slopes, alpha_x=a, alpha_y=a) for a in alphas.tolist()]
    sides = (material, other_side(material)) if material.transmits else (material,)
    if name == SURFACES:
        tables: Sequence[Adds] = [_of_surfaces(rough, m, textured, seed, workers) for m in sides]
    else:
        table = solved_table(rough, material, textured, workers, quiet)
        tables = [table, replace(table, within=True)][: len(sides)]
    outside, *inside = (Tabulated(name, slopes, m, t) for m, t in zip(sides, tables, strict=True))
    return outside, next(iter(inside), None)


def _of_surfaces(
    rough: list[Slopes], material: Material, textured: bool, seed: int, workers: Workers
) -> Table:
    """Of surfaces of ascending roughness."""
    levels = [_level(slopes, material, seed, workers) for slopes in rough]
    axes = np.array(THETA_OF_SURFACES), *_bin_axes()
    alphas = np.array([0.0, *(slopes.alpha_x for slopes in rough)])
    values = np.stack([level.values for level in levels], axis=1)
    # Without a texture all roughness has the same: interpolation needs two.
    smooth = np.zeros_like(values[:, :1]) if textured else values
    error = max(level.error for level in levels) + _between(levels, axes)
    return Table(alphas, *axes, np.concatenate([smooth, values], axis=1), error)


@dataclass(frozen=True)
class Level:
    """A table of one roughness, (sides, theta_i, theta_o, azimuth, channels), and its error as a
    share of the light that leaves."""

    values: Array
    error: float


def _between(levels: list[Level], axes: tuple[Array, Array, Array]) -> float:
    """What is missed between roughnesses: an eighth of the second difference, as a share of light
    from everywhere."""
    if len(levels) < 3:
        return 0.0
    bend = np.abs(np.diff([level.values for level in levels], 2, axis=0)) / 8
    theta_i, theta_o, azimuth = axes
    over_azimuth = 2 * trapezoid(bend, azimuth, axis=4)
    out = trapezoid(over_azimuth * np.sin(2 * theta_o)[:, None] / 2, theta_o, axis=3).sum(axis=1)
    return float(trapezoid(out * np.sin(2 * theta_i)[:, None], theta_i, axis=1).max())


def _level(slopes: Slopes, material: Material, seed: int, workers: Workers) -> Level:
    """Lobes traced on surfaces, less those of single scattering in the same bins."""
    channels = _channels(material)
    parts = [_lobes(slopes, one, seed, workers) for one in channels]
    values = np.stack([values for values, _ in parts], axis=-1)
    return Level(values, max(error for _, error in parts))


def _channels(material: Material) -> list[Material]:
    """Materials of one channel each, as surfaces are traced with."""
    if material.channels == 1:
        return [material]
    if isinstance(material, Conductor):
        return [Conductor((pair,)) for pair in material.eta_k]
    return [replace(material, albedo=a) for a in material.albedos]  # type: ignore[type-var]


def _lobes(slopes: Slopes, material: Material, seed: int, workers: Workers) -> tuple[Array, float]:
    scene = Scene(material, slopes, THETA_OF_SURFACES, orders=1)
    resolution = plan(scene, ACCURACY, None, None, None, None)
    nothing = FreePaths((), (), np.array([0.0, 1.0]))
    run = simulate(scene, RAYS, resolution, nothing, seed, workers, 10_000, quiet=True)
    lobes = run.lobes()
    sides = len(lobes.sides)
    density = lobes.density.sum(axis=1)[:, :sides]
    stderr = np.sqrt((lobes.density_stderr**2).sum(axis=1))[:, :sides]
    added = density - np.stack([_of_single(scene, i) for i in range(len(scene.theta))])[:, :sides]
    theta_o, _, solid_angle = lobe_axes()
    weight = solid_angle[:, None]
    error = float((stderr * weight).sum() / (density * weight).sum())
    bsdf = added / np.cos(theta_o)[:, None]
    # Of two azimuths either side of the plane of incidence the mean: surfaces have no handedness.
    half = PHI_BINS // 2
    there = bsdf[..., : half + 1]
    back = np.concatenate([bsdf[..., :1], bsdf[..., : half - 1 : -1]], axis=-1)
    return np.moveaxis((there + back) / 2, 1, 0), error


def _of_single(scene: Scene, i: int) -> Array:
    """Density of single scattering in bins, (2, theta, phi), by its own samples."""
    single = Single(scene.slopes, scene.material, 1)
    rng = stream(0, "model lobe", "single", i, 0)
    w, weight = single.sample(scene.wi(scene.theta[i]), SAMPLES_OF_SINGLE, rng)
    bins = THETA_BINS * PHI_BINS
    energy = [np.bincount(lobe_bin(w[:, at]), weight[0, at], bins) for at in (w[2] > 0, w[2] < 0)]
    solid_angle = lobe_axes()[2][:, None]
    return np.reshape(energy, (2, THETA_BINS, PHI_BINS)) / SAMPLES_OF_SINGLE / solid_angle


def _bin_axes() -> tuple[Array, Array]:
    """Middles of the bins in polar angle, and in azimuth from 0 to pi."""
    theta, phi, _ = lobe_axes()
    return theta, phi[: PHI_BINS // 2 + 1]
