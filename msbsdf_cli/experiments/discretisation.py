"""What flat facets and a finite period do to the figures of a simulation: part of their errors.

The mesh is judged by a coarser one of the same fields under the same rays. The period is judged by
a law that was measured beforehand, since fields of different periods have nothing in common.
"""

import numpy as np

from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, lobe_axes, merge_bins
from msbsdf_cli.statistics.tally import Tally
from surfaces.facet import Array

COARSER = 2
"""Cells of the mesh over those of the coarser one.

The error is taken to be as large as the difference between the two: the grid convergence index of
two grids of second order, 3 x difference / (2^2 - 1) (P. J. Roache, Perspective: a method for
uniform reporting of grid refinement studies, J. Fluids Eng. 116, 1994), whose safety factor of 3
stands for not knowing whether the cells are small enough for the second order to show.
"""

FEWEST_PAIRS = 8
"""Realisations that are traced on the coarser mesh too, or all if they are fewer; of many, half."""

PERIOD = 0.06
"""Light that is moved between the first order and the later ones by a period of 1 correlation
length; it falls with the square. Measured at 6 correlation lengths as .0015 (alpha 0.25 to 1,
theta 1 and 1.5), with noise of .0006; it does not show from 12 on."""


def pairs(realisations: int) -> int:
    """How many realisations are traced on the coarser mesh as well."""
    return min(realisations, max(FEWEST_PAIRS, realisations // 2))


def squared_errors(tally: Tally, coarser: Tally, extent: float) -> Array:
    """Squares of the errors of cells and period, as a row of `Tally.sums`.

    `tally` holds the simulation, `coarser` what light on the coarser mesh has more.
    """
    errors = np.zeros_like(tally.systematic)
    views, values = tally.views(errors), tally.views(tally.sums[0] / tally.units)
    for name in views:
        found = coarser.estimate(name)
        # Without its noise, which is no error of the mesh.
        views[name][...] = np.maximum(found.value**2 - found.stderr**2, 0)
    moved = _moved_by_period(values["energy"], extent)
    views["energy"][...] += (moved * values["energy"]) ** 2
    views["moments"][...] += (moved[..., None] * values["moments"]) ** 2
    views["sequence"][...] += (moved.max() * values["sequence"]) ** 2
    for name in ("side", "absorbed"):
        # Nothing is moved where all the light is, or none.
        views[name][...] += moved.max() ** 2 * values[name] * np.maximum(1 - values[name], 0)
    relative = _relative_lobe_error(values["lobe"], coarser) ** 2 + moved**2
    views["lobe"][...] = relative[..., None] * values["lobe"] ** 2
    return errors


def _relative_lobe_error(lobe: Array, coarser: Tally) -> Array:
    """Root mean square error of each order's lobe by the mesh over its root mean square, (order,
    side), in merged bins: in single ones noise would drown it."""
    solid_angle = merge_bins(np.repeat(lobe_axes()[2][:, None], PHI_BINS, axis=1))
    apart = coarser.estimate("lobe")
    shape = THETA_BINS, PHI_BINS
    relative = np.zeros(lobe.shape[:2])
    for place in np.ndindex(relative.shape):
        difference, noise, value = (
            merge_bins(a[place].reshape(shape)) for a in (apart.value, apart.stderr**2, lobe)
        )
        scale = (value**2 / solid_angle).sum()
        square = ((difference**2 - noise) / solid_angle).sum()
        relative[place] = np.sqrt(max(square / scale, 0)) if scale > 0 else 0
    return relative


def _moved_by_period(energy: Array, extent: float) -> Array:
    """Relative error (order, 1) by the period of each order's light, from energies (order, side):
    what is moved between the first order and the later ones is shared in proportion."""
    first, later = energy[0].sum(), energy[1:].sum()
    moved = min(PERIOD / extent**2, first, later)
    relative = np.full((len(energy), 1), moved / later if later > 0 else 0.0)
    relative[0] = moved / first if first > 0 else 0.0
    return relative
