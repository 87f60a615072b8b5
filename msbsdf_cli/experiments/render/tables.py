"""How tables for pictures are made: of `solve`, and of light traced on explicit surfaces."""

from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from scipy.integrate import trapezoid

from msbsdf_cli.experiments.realisations import simulate
from msbsdf_cli.experiments.render.tabulated import Table, Tabulated
from msbsdf_cli.experiments.resolution import plan
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.single import Single
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.results.free_paths import FreePaths
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.scene import Scene, direction
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

THETA_NODES, AZIMUTH_NODES = 20, 19
"""Of a table of `solve`, evenly spaced."""
STEEPEST = 1.55
"""The largest polar angle of a table, in radians."""
INCIDENT, OUTGOING = 8, 128
"""Directions in which a table of `solve` is held against it."""

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
        Solve.check_supported(slopes, material)
        if material.transmits:
            raise UnsupportedError(
                f"method {name} needs seconds for each pair of directions of {material.name} "
                "facets, and a table has 10 000; walk-low-variance shades the same model"
            )


def tabulated(
    name: str, slopes: Slopes, material: Material, textured: bool, seed: int, workers: Workers
) -> Tabulated:
    """`solve` or the surfaces as a table, if textured for all roughnesses up to that of `slopes`.
    Raises UnsupportedError for what no table is made of."""
    check_tabulated(name, slopes, material)
    top = slopes.alpha_x
    alphas = np.linspace(0, top, LEVELS) if textured else np.array([top])
    rough = [replace(slopes, alpha_x=a, alpha_y=a) for a in alphas.tolist() if a > 0]
    if name == SURFACES:
        levels = [_of_surfaces(of, material, seed, workers) for of in rough]
        axes = np.array(THETA_OF_SURFACES), *_bin_axes()
    else:
        levels = [_of_solve(of, material, workers) for of in rough]
        axes = _nodes(), _nodes(), np.linspace(0, np.pi, AZIMUTH_NODES)
    values = np.stack([level.values for level in levels], axis=1)
    if textured:
        values = np.concatenate([np.zeros_like(values[:, :1]), values], axis=1)
    else:
        # Interpolation needs two.
        alphas, values = np.array([0.0, top]), np.concatenate([values, values], axis=1)
    error = max(level.error for level in levels) + _between(levels, axes)
    return Tabulated(name, slopes, material, Table(alphas, *axes, values, error))


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


def _nodes() -> Array:
    return np.linspace(0, STEEPEST, THETA_NODES)


@lru_cache(maxsize=1)
def _solved(slopes: Slopes, material: Material) -> Solve:
    """Kept for all rows; processes that are forked after it was made have it too."""
    return Solve(slopes, material, 1)


def _of_solve(slopes: Slopes, material: Material, workers: Workers) -> Level:
    """The later orders of `solve`."""
    _solved(slopes, material)
    row = partial(_row, slopes, material)
    values = np.stack(list(map_ordered(row, _nodes().tolist(), workers)), axis=1)
    azimuth, two = np.linspace(0, np.pi, AZIMUTH_NODES), np.stack([values, values], axis=1)
    table = Table(np.array([0.0, 1.0]), _nodes(), _nodes(), azimuth, two, 0.0)
    return Level(values, _off(_solved(slopes, material), table))


def _row(slopes: Slopes, material: Material, theta_i: float) -> Array:
    """BSDF of the later orders for one incident angle, (sides, theta_o, azimuth, channels)."""
    azimuth, sides = np.linspace(0, np.pi, AZIMUTH_NODES), (1, -1)[: 1 + material.transmits]
    theta, phi = (a.ravel() for a in np.meshgrid(_nodes(), azimuth, indexing="ij"))
    x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    wo = np.concatenate([np.stack([x, y, side * z]) for side in sides], axis=1)
    found = _solved(slopes, material).evaluate(direction(theta_i), wo).value[:, 1] / np.abs(wo[2])
    return np.asarray(found.T).reshape(len(sides), THETA_NODES, AZIMUTH_NODES, -1)


def _off(solve: Solve, table: Table) -> float:
    """Integral over the upper hemisphere of a table's distance from `solve`, over the energy that
    leaves, for random incident directions."""
    rng = stream(0, "table directions")
    off, energy = 0.0, 0.0
    for theta in np.arccos(rng.uniform(np.cos(STEEPEST), 1, INCIDENT)).tolist():
        z, phi = rng.random((2, OUTGOING)) * np.array([[1], [2 * np.pi]])
        radius, wi = np.sqrt(1 - z * z), direction(theta)
        wo = np.stack([radius * np.cos(phi), radius * np.sin(phi), z])
        value = solve.evaluate(wi, wo).value[:, 1]
        mine = table(1.0, np.tile(wi[:, None], OUTGOING), wo, np.zeros(OUTGOING, bool)) * z
        off += 2 * np.pi * float(np.abs(mine - value).mean())
        known = solve.energy(wi)
        energy += float((known.reflected + known.transmitted).sum(axis=1).mean())
    return off / energy


def _of_surfaces(slopes: Slopes, material: Material, seed: int, workers: Workers) -> Level:
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
