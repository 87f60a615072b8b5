"""A solved BSDF as a table that renderers interpolate, and tables of albedos.

Of mirrors and metals the first order has a closed form, in which a lobe may be as narrow as it
likes; the table holds the later orders, which are wide. Of diffuse facets it holds all. The surface
has one roughness, so that a value depends on two cosines and the azimuth between the directions.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.single import Single
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.methods.solver.size import value_seconds
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Conductor, Material
from surfaces.streams import stream

SLOPES = ("beckmann", "ggx")
"""Slope distributions that renderers have."""

COSINES, LEAST_AZIMUTHS, AZIMUTHS_OF_ALPHA = 24, 24, 20
"""Nodes of the table, at the middles of as many even parts of [0, 1] and [0, pi]: of azimuths more
where the surface is smooth, in proportion to 1 / alpha, as lobes are narrow."""

VALUE_S, VALUE_OF_DIFFUSE_S = 2.5e-4, 6e-4
"""Seconds for a value; the first order of diffuse facets is an integral."""

PAIRS, LEAST_COSINE = 512, float(np.cos(1.4))
"""Random pairs of directions in which a table is held against what it was made from, and the
cosine of the steepest of them."""

FAINT = 0.01 / (2 * np.pi)
"""Values of a BSDF x cosine below which errors are relative to this: a hundredth of light that is
spread evenly."""

ALBEDO_ALPHAS, ALBEDO_COSINES = 32, 32
"""Nodes of the table of albedos, at the middles of even parts of [0, 1]."""


@dataclass(frozen=True)
class BsdfTable:
    """BSDF values of the orders that have no closed form."""

    slopes: Slopes
    material: Material
    values: Array
    """Per steradian, without the cosine, (channels, cosine in, cosine out, azimuth)."""

    def evaluate(self, wi: Array, wo: Array) -> Array:
        """BSDF x cos(theta_o), (channels, n), for a unit vector (3,) and unit vectors (3, n) above
        the surface: what a renderer makes of the table."""
        phi = np.abs(np.arctan2(wo[1], wo[0]) - np.arctan2(wi[1], wi[0]))
        phi = np.minimum(phi, 2 * np.pi - phi)
        places = np.full_like(phi, wi[2]), wo[2], phi / np.pi
        found = _interpolated(self.values, places) * wo[2]
        if self.material.specular:
            single = Single(self.slopes, self.material, 1)
            rng = stream(0, "without noise")
            found = found + single.evaluate(wi, wo, 1, rng).value[:, 0]
        return np.asarray(found)


def make_table(slopes: Slopes, material: Material, workers: Workers, quiet: bool) -> BsdfTable:
    """Solve the Smith model for all nodes. Raises UnsupportedError for a surface of two
    roughnesses, or one that light passes through."""
    check(slopes, material)
    jobs = [(slopes, material, k) for k in range(COSINES)]
    values = np.empty((material.channels, COSINES, COSINES, azimuths(slopes)))
    with Progress("export", COSINES, "angles", quiet) as progress:
        for k, row in enumerate(map_ordered(_row, jobs, workers)):
            # A BSDF is reciprocal: half of it is the other half.
            values[:, k, k:] = values[:, k:, k] = row
            progress.advance(1)
    return BsdfTable(slopes, material, values)


def seconds(slopes: Slopes, material: Material) -> float:
    """About how many seconds one core needs for a table."""
    each = VALUE_S if material.specular else VALUE_OF_DIFFUSE_S
    values = COSINES * (COSINES + 1) / 2 * azimuths(slopes)
    return COSINES * value_seconds(slopes, material) + each * values


def check(slopes: Slopes, material: Material) -> None:
    """Raise UnsupportedError for what no table is made of."""
    if slopes.name not in SLOPES:
        raise UnsupportedError(f"renderers have slopes {' and '.join(SLOPES)}, not {slopes.name}")
    if slopes.alpha_x != slopes.alpha_y:
        raise UnsupportedError("a table has room for one roughness, and there are two")
    if material.transmits:
        raise UnsupportedError("a table has room for one side, and light passes through")
    Solve.check_supported(slopes, material)


def azimuths(slopes: Slopes) -> int:
    """Nodes in azimuth."""
    return max(LEAST_AZIMUTHS, int(np.ceil(AZIMUTHS_OF_ALPHA / slopes.alpha_x)))


def nodes(count: int) -> Array:
    """Middles of even parts of [0, 1]: where textures have their values."""
    return (np.arange(count) + 0.5) / count


def _row(job: tuple[Slopes, Material, int]) -> Array:
    """Values (channels, cosine out, azimuth) for the incident cosine of number k and outgoing ones
    from there on."""
    slopes, material, k = job
    cos_i, cos_o, phi = nodes(COSINES)[k], nodes(COSINES)[k:], np.pi * nodes(azimuths(slopes))
    wi = np.array([np.sqrt(1 - cos_i**2), 0, cos_i])
    sin_o = np.sqrt(1 - cos_o**2)
    across = (np.outer(sin_o, f(phi)).ravel() for f in (np.cos, np.sin))
    wo = np.array([*across, np.repeat(cos_o, phi.size)])
    value = Solve(slopes, material, 1).evaluate(wi, wo).value
    wanted = value[:, 1] if material.specular else value.sum(axis=1)
    return np.asarray(wanted / wo[2]).reshape(len(value), cos_o.size, phi.size)


def _interpolated(values: Array, places: tuple[Array, ...]) -> Array:
    """Linear between the middles of texels, constant beyond them: (channels, n)."""
    grid = [nodes(count) for count in values.shape[1:]]
    inside = [np.clip(x, axis[0], axis[-1]) for x, axis in zip(places, grid, strict=True)]
    found = RegularGridInterpolator(grid, np.moveaxis(values, 0, -1))(np.stack(inside, axis=-1))
    return np.asarray(found.T)


def interpolation_error(table: BsdfTable, seed: int = 0) -> Array:
    """Relative errors (pairs,) of the whole BSDF in random pairs of directions up to theta 1.4."""
    rng = stream(seed, "export pairs")
    solve, errors = Solve(table.slopes, table.material, 1), []
    for _ in range(PAIRS // 32):
        cos = rng.uniform(LEAST_COSINE, 1, 33)
        phi = rng.uniform(0, 2 * np.pi, 33)
        sin = np.sqrt(1 - cos**2)
        w = np.array([sin * np.cos(phi), sin * np.sin(phi), cos])
        truth = solve.evaluate(w[:, 0], w[:, 1:]).value.sum(axis=1)
        mine = table.evaluate(w[:, 0], w[:, 1:])
        errors.append((np.abs(mine - truth) / np.maximum(truth, FAINT)).max(axis=0))
    return np.concatenate(errors)


def albedos(slopes: Slopes) -> tuple[Array, Array]:
    """Directional albedo of mirrors by single scattering over alpha and cosine, (alphas, cosines),
    and its mean over the hemisphere, (alphas,): what energy compensation looks up."""
    cos = nodes(ALBEDO_COSINES)
    wi = np.array([np.sqrt(1 - cos * cos), np.zeros_like(cos), cos])
    rows = []
    for alpha in nodes(ALBEDO_ALPHAS).tolist():
        of = replace(slopes, alpha_x=alpha, alpha_y=alpha)
        rows.append(first_order_albedo(of, Conductor(), wi))
    directional = np.array(rows)
    return directional, (directional * 2 * cos).mean(axis=1)
