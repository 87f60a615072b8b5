"""`solve` in pictures: the tables that renderers read, one for each of some roughnesses.

Between two roughnesses the table is linear; at roughness 0 mirrors and glass send on nothing after
their first facet, and diffuse facets are a plane.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from msbsdf_cli.methods.solve import solution
from msbsdf_cli.methods.solver.dielectric import DielectricSolution
from msbsdf_cli.methods.solver.opaque import OpaqueSolution
from msbsdf_cli.renderers.nodes import Nodes
from msbsdf_cli.renderers.tables import BsdfTable, first_value, other_side
from msbsdf_cli.renderers.tabulate import directions, make_table
from msbsdf_cli.run.executors import Workers, map_ordered
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material
from surfaces.streams import stream

GLASS_ELEVATIONS, GLASS_AZIMUTHS, GLASS_RESOLUTION = (8, 9), 16, 0.35
"""Of tables of glass, some ten times as fast as those that are exported."""

INCIDENT, ELEVATIONS, AZIMUTHS = 4, 6, 8
"""Directions in which a table is held against `solve`, on either side."""
TRUTH = 0.75
"""Resolution of the solution of glass for that: right to a thousandth where tables are to
hundredths."""


@dataclass(frozen=True)
class SolvedTable:
    """BSDF values over roughness."""

    levels: tuple[BsdfTable, ...]
    """In ascending order of roughness."""
    textured: bool
    error: float
    """Share of the light that the table sends elsewhere, or is lacking."""
    within: bool = False
    """Whether light arrives from inside."""

    @property
    def whole(self) -> bool:
        """Whether the first order is in the table."""
        return not self.levels[0].material.specular

    def __call__(self, alpha: Array | float, wi: Array, w: Array, inside: Array) -> Array:
        """As `tabulated.Table` has it."""
        wo = np.where(inside, -w, w)
        if self.within:
            wi, wo = wi * [[1], [1], [-1]], wo * [[1], [1], [-1]]
        if not self.textured:
            return self.levels[0].later(wi, wo)
        alphas = [0.0, *(level.slopes.alpha_x for level in self.levels)]
        place = np.broadcast_to(np.interp(alpha, alphas, np.arange(len(alphas))), inside.shape)
        smooth = np.array(self.levels[0].material.albedos)[:, None] / np.pi * self.whole
        value = np.maximum(1 - place, 0) * smooth
        for number, level in enumerate(self.levels, 1):
            share = 1 - np.abs(place - number)
            lanes = np.flatnonzero(share > 0)
            value[:, lanes] += share[lanes] * level.later(wi[:, lanes], wo[:, lanes])
        return np.asarray(value)


def solved_table(
    levels: list[Slopes], material: Material, textured: bool, workers: Workers, quiet: bool
) -> SolvedTable:
    """The table for slopes of ascending roughness, made and held against `solve`."""
    made = []
    for slopes in levels:
        label = f"table of alpha {slopes.alpha_x:.3g}"
        nodes, resolution = None, 1.0
        if material.transmits:
            nodes = Nodes.of_glass(material.ior, *GLASS_ELEVATIONS, GLASS_AZIMUTHS)
            resolution = GLASS_RESOLUTION
        made.append(make_table(slopes, material, workers, quiet, nodes, resolution, label))
    table = SolvedTable(tuple(made), textured, 0.0)
    tops = [slopes.alpha_x for slopes in levels]
    # Half way between two roughnesses the table is furthest off.
    halves = [(a + b) / 2 for a, b in zip([0.0, *tops], tops, strict=False)]
    alphas = [halves[0], halves[len(halves) // 2], halves[-1]] if textured else tops
    jobs = [
        (table, replace(levels[0], alpha_x=a, alpha_y=a), within)
        for a in dict.fromkeys(alphas)
        for within in ((False, True) if material.transmits else (False,))
    ]
    return replace(table, error=max(map_ordered(_off, jobs, workers)))


def _off(job: tuple[SolvedTable, Slopes, bool]) -> float:
    """Integral over outgoing directions of a table's distance from `solve`, over the energy that
    leaves, for random incident directions."""
    table, slopes, within = job
    table, material = replace(table, within=within), table.levels[0].material
    if within:
        material = other_side(material)
    solved = _solved(slopes, material)
    rng = stream(0, "table directions")
    wi = directions(np.arccos(rng.random(INCIDENT)), np.zeros(1))
    wo = directions(np.arccos(rng.random(ELEVATIONS)), rng.uniform(0, 2 * np.pi, AZIMUTHS))
    sides = (False, True) if material.transmits else (False,)
    ends = np.concatenate([-wo if side else wo for side in sides], axis=1)
    inside = ends[2] < 0
    truth = solved.pairs(wi, ends)[0].sum(axis=2)
    off = energy = 0.0
    for d, value in zip(wi.T, truth, strict=True):
        if table.whole:
            value = value + first_value(slopes, material, d, ends)
        one = np.tile(d[:, None], inside.size)
        mine = table(slopes.alpha_x, one, np.where(inside, -ends, ends), inside) * np.abs(ends[2])
        off += 2 * np.pi * len(sides) * float(np.abs(mine - value).mean())
        energy += float(solved.energy(d).sum(axis=(1, 2)).mean())
    return off / energy


@lru_cache(maxsize=2)
def _solved(slopes: Slopes, material: Material) -> OpaqueSolution | DielectricSolution:
    """Once in each process."""
    return solution(slopes, material, 1, TRUTH if material.transmits else 1.0)
