"""How well energies are known after ever more surfaces, and what that took."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.statistics.surface_tally import SurfaceTally
from msbsdf_cli.statistics.tally import Tally
from surfaces.facet import Array

FEWEST = 8
"""Surfaces of the first row: with fewer, noise itself is hardly known."""


@dataclass(frozen=True)
class Spent:
    """Seconds of one core on one surface, for one incident angle."""

    surface_s: float
    """For making the surface, whatever the number of angles."""
    trace_s: float
    coarser_s: float
    """For making coarser meshes and tracing on them."""


@dataclass(frozen=True)
class Known:
    """What so many surfaces tell of the energies of one incident angle."""

    surfaces: int
    energy: Array
    """(orders + 1, sides)."""
    one: Array
    """Squared noise and squared bias (2,), summed over energies, of the mean on one mesh; its bias
    is the step from there to what three meshes say, and what is in doubt of that."""
    three: Array
    """The same with controls and extrapolation; the bias is what is in doubt of mesh and period."""


def known(tally: SurfaceTally) -> Known:
    """From the sums over surfaces so far."""

    def energies(row: Array) -> Array:
        return tally.views(row)["energy"]

    value, squares = tally.figures()
    step, step_noise = tally.more.figures()
    mesh = max(float((energies(step) ** 2 - energies(step_noise)).sum()), 0.0)
    systematic = energies(tally.systematic).sum()
    return Known(
        tally.units,
        energies(value),
        np.array([energies(Tally.figures(tally)[1]).sum(), mesh + systematic]),
        np.array([energies(squares).sum() - systematic, systematic]),
    )
