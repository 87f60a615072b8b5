"""The work behind a table: all its nodes solved for, and how far it is off in between."""

from functools import lru_cache

import numpy as np

from msbsdf_cli.methods.solve import Solve, solution
from msbsdf_cli.methods.solver.dielectric import DielectricSolution
from msbsdf_cli.methods.solver.opaque import OpaqueSolution
from msbsdf_cli.methods.solver.size import value_seconds
from msbsdf_cli.renderers.nodes import Nodes
from msbsdf_cli.renderers.tables import BLOCKS, BsdfTable, check, first_value, other_side
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.run.progress import Progress
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material
from surfaces.streams import stream

LEAST_AZIMUTHS, AZIMUTHS_OF_ALPHA = 32, 6
LEAST_AZIMUTHS_OF_GLASS, AZIMUTHS_OF_ALPHA_OF_GLASS = 28, 14
"""Nodes in azimuth of one roughness: more on smooth surfaces, in proportion to 1 / alpha, as lobes
are narrow."""

ELEVATIONS_OF_GLASS = 18, 20
"""Nodes on either side of the angle where elevations are split. The time for a table goes by their
square; with 12 and 14 those of Beckmann slopes were up to 3 % off."""

RESOLUTION_OF_GLASS = 0.8
"""Of the solution that a dielectric's table is made of, twice as fast as at 1: there values are
right to some thousandths, 1 % at worst; at .6 transmission of alpha 0.2 is off by as much again."""

PAIR_OF_DIFFUSE_S, PAIR_OF_GLASS_S, ROW_S = 2e-4, 1.2e-2, 2.5e-8
"""Seconds for a pair of directions: the first order of diffuse facets is an integral over the
facets, and the second of glass another, here at resolution 1. For a direction among kernels of two
roughnesses, for each product of two of their directions."""

PAIR_POWER = 2.7
"""Power of the resolution that the time for a pair of glass goes by, as measured."""

LIGHTS, ELEVATIONS, AZIMUTHS = 8, 8, 8
"""Random directions of incidence on either side, and for each outgoing elevations and azimuths on
either side, in which a table is held against `solve`."""

FINER = 1.5
"""Factor between the resolution of `solve` for glass in these directions and that of its tables;
for opaque surfaces both are the usual one."""

LEAST_COSINE = float(np.cos(1.4))
"""Of the steepest of these directions."""

FAINT = 0.01 / (2 * np.pi)
"""Values of a BSDF x cosine below which errors are relative to this: a hundredth of light that is
spread evenly."""


def nodes_for(slopes: Slopes, material: Material) -> Nodes:
    """As many as a table of some megabytes has room for."""
    alpha, wide = sorted((slopes.alpha_x, slopes.alpha_y))
    if material.transmits:
        needed = int(np.ceil(AZIMUTHS_OF_ALPHA_OF_GLASS / alpha))
        azimuths = max(LEAST_AZIMUTHS_OF_GLASS, needed)
        return Nodes.of_glass(material.ior, *ELEVATIONS_OF_GLASS, azimuths)
    if alpha == wide:
        return Nodes(24, max(LEAST_AZIMUTHS, int(np.ceil(AZIMUTHS_OF_ALPHA / alpha))))
    eighths = int(np.clip(np.ceil(2 / alpha), 6, 10))
    return Nodes(18, 8 * eighths, eighths + 1)


def resolution_for(material: Material) -> float:
    """Of the solution that a table is made of."""
    return RESOLUTION_OF_GLASS if material.transmits else 1.0


def seconds(slopes: Slopes, material: Material) -> float:
    """About how many seconds one core needs for a table."""
    nodes = nodes_for(slopes, material)
    n, pairs = nodes.elevations, nodes.elevations**2 * nodes.azimuths
    if material.transmits:
        checked = 2 * LIGHTS * ELEVATIONS * AZIMUTHS * 2
        each = PAIR_OF_GLASS_S * resolution_for(material) ** PAIR_POWER
        return 4 * value_seconds(slopes, material) + each * (2 * pairs + 5 * checked)
    if nodes.incident > 1:
        rows = n * (nodes.azimuths + n * nodes.incident)
        one = value_seconds(slopes, material)
        return 6 * one + ROW_S * rows * (one / 8e-9) ** (2 / 3)
    diffuse = 0 if material.specular else PAIR_OF_DIFFUSE_S * pairs / 2
    return n * value_seconds(slopes, material) / 4 + diffuse


def make_table(
    slopes: Slopes,
    material: Material,
    workers: Workers,
    quiet: bool,
    nodes: Nodes | None = None,
    resolution: float | None = None,
    label: str = "export",
) -> BsdfTable:
    """Solve the Smith model for all nodes, by default those of `nodes_for`, at a resolution of
    `solve`. Raises UnsupportedError for what has no table."""
    check(slopes, material)
    nodes = nodes_for(slopes, material) if nodes is None else nodes
    n, blocks = nodes.elevations, len(BLOCKS) if material.transmits else 1
    if resolution is None:
        resolution = resolution_for(material)
    jobs = [(slopes, material, nodes, resolution, b, k) for b in range(blocks) for k in range(n)]
    shape = material.channels, blocks, nodes.incident, n, n, nodes.azimuths
    values = np.empty(shape)
    work = _glass if material.transmits else _opaque
    with Progress(label, len(jobs), "angles", quiet) as progress:
        for job, row in zip(jobs, map_ordered(work, jobs, workers), strict=True):
            *_, block, k = job
            if block == 1:
                values[0, 1, 0].swapaxes(0, 1 - nodes.dense_inside)[:, k] = row
            elif material.transmits:
                # Half of the pairs are the other half reversed, which is more accurate where it
                # comes in further from the horizon.
                below = slice(k + 1)
                values[0, block, 0, below, k] = values[0, block, 0, k, below] = row
            elif nodes.incident == 1:
                values[:, 0, :, k:, k], values[:, 0, :, k, k:] = row, row
            else:
                values[:, 0, :, :, k] = row
            progress.advance(1)
    return BsdfTable(slopes, material, nodes, values)


Job = tuple[Slopes, Material, Nodes, float, int, int]


def _opaque(job: Job) -> Array:
    """Values (channels, azimuths of incidence, elevations in, azimuths between) of the outgoing
    elevation of number k: from elevations k on, or all, where azimuths of incidence differ."""
    slopes, material, nodes, resolution, _, k = job
    theta = nodes.theta if nodes.incident > 1 else nodes.theta[k:]
    wi = directions(theta, nodes.phi_i)
    wo = directions(nodes.theta[[k]], nodes.phi)
    solved = _solution(slopes, material, resolution)
    value = solved.pairs(wi, wo)[0][:, :, 1]
    if not material.specular:
        value = value + [first_value(slopes, material, w, wo) for w in wi.T]
    shape = theta.size, nodes.incident, material.channels, nodes.azimuths
    rows = np.moveaxis((value / wo[2]).reshape(shape), 0, 2)
    # Azimuths of incidence are among those between.
    step = nodes.azimuths // (4 * max(nodes.incident - 1, 1))
    turned = [np.roll(row, -step * i, axis=-1) for i, row in enumerate(rows)]
    return np.stack(turned, axis=1)


def _glass(job: Job) -> Array:
    """Values (elevations, azimuths): reflected at the outgoing elevation of number k, up to that of
    incidence; or transmitted, of elevation k in the medium of higher index, of all in the other."""
    slopes, material, nodes, resolution, block, k = job
    if block == 1:
        return _transmitted(slopes, material, nodes, resolution, k)
    solved = _solution(slopes, other_side(material) if block else material, resolution)
    assert isinstance(solved, DielectricSolution)
    wi, wo = directions(nodes.theta, np.zeros(1)), directions(nodes.theta[[k]], nodes.phi)
    return np.asarray(solved.pairs(wi, wo, k + 1)[0][:, 0, 1] / wo[2])


def _transmitted(
    slopes: Slopes, material: Material, nodes: Nodes, resolution: float, k: int
) -> Array:
    """Each pair from where it is further from the horizon, and light inwards in the end."""
    both = material, other_side(material)
    thin, dense = both if nodes.dense_inside else both[::-1]
    theta, down = nodes.thin_theta(k), np.array([[1], [1], [-1]])
    row = np.empty((nodes.elevations, nodes.azimuths))
    near = theta <= nodes.theta[k]
    if near.any():
        wo = directions(nodes.theta[[k]], nodes.phi)
        solved = _solution(slopes, thin, resolution)
        value = solved.pairs(directions(theta[near], np.zeros(1)), wo * down)[0]
        row[near] = value[:, 0, 1] / wo[2]
    if not near.all():
        wo = directions(theta[~near], nodes.phi)
        solved = _solution(slopes, dense, resolution)
        value = solved.pairs(directions(nodes.theta[[k]], np.zeros(1)), wo * down)[0]
        # Light that enters the medium of higher index is that much denser.
        row[~near] = (value[0, 0, 1] / wo[2] * thin.ior**2).reshape(-1, nodes.azimuths)
    return row if nodes.dense_inside else row / thin.ior**2


@lru_cache(maxsize=2)
def _solution(
    slopes: Slopes, material: Material, resolution: float
) -> OpaqueSolution | DielectricSolution:
    """Once in each process."""
    return solution(slopes, material, 1, resolution)


def directions(theta: Array, phi: Array) -> Array:
    """Directions (3, polar angles x azimuths)."""
    sin, cos = np.sin(theta), np.cos(theta)
    across = (np.outer(sin, f(phi)).ravel() for f in (np.cos, np.sin))
    return np.array([*across, np.repeat(cos, phi.size)])


def table_error(table: BsdfTable, workers: Workers, seed: int = 0) -> tuple[Array, Array]:
    """Relative errors of the whole BSDF in random pairs of directions up to theta 1.4, those of the
    table against `solve` and of `solve` by its own estimate, (pairs,) each, light going either way.
    Of three channels the largest counts."""
    sides = 2 if table.material.transmits else 1
    jobs = [(table, side, seed, k) for side in range(sides) for k in range(LIGHTS)]
    found = list(map_ordered(_errors, jobs, workers))
    errors, known = np.concatenate(found, axis=-1)
    return errors, known


def _errors(job: tuple[BsdfTable, int, int, int]) -> Array:
    """For light from one direction on either side, and back to there."""
    table, side, seed, k = job
    material = other_side(table.material) if side else table.material
    wi, wo = random_pairs(stream(seed, "export pairs", side, k))
    down = np.array([[1], [1], [-1]])
    if material.transmits:
        wo = np.concatenate([wo, wo * down], axis=1)
    finer = FINER * resolution_for(material) if material.transmits else 1.0
    truth, known, _ = _solve(table.slopes, material, finer).pairs(wi[:, None], wo)
    truth, known = truth[0].sum(axis=1), known[0].sum(axis=1)
    mine = table.evaluate(*((wi * down[:, 0], wo * down) if side else (wi, wo)))
    off, back = np.stack([np.abs(mine - truth), known]), wi[2] / np.abs(wo[2])
    if material.transmits:
        back = back / np.where(wo[2] < 0, material.ior, 1) ** 2
    both = [off * way / np.maximum(truth * way, FAINT) for way in (1, back)]
    return np.concatenate(both, axis=-1).max(axis=1)


def random_pairs(rng: np.random.Generator) -> tuple[Array, Array]:
    """A direction (3,) and others (3, n), all with z > 0. Of two random polar angles the smaller is
    that of incidence: that way `solve` is more accurate, and by reciprocity the other way too."""
    cos = rng.uniform(LEAST_COSINE, 1, 2).max(keepdims=True)
    wi = directions(np.arccos(cos), rng.uniform(0, 2 * np.pi, 1))[:, 0]
    theta = np.arccos(rng.uniform(LEAST_COSINE, cos, ELEVATIONS))
    return wi, directions(theta, rng.uniform(0, 2 * np.pi, AZIMUTHS))


@lru_cache(maxsize=2)
def _solve(slopes: Slopes, material: Material, resolution: float) -> Solve:
    """Once in each process."""
    return Solve(slopes, material, 1, resolution)
