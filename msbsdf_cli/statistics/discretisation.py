"""What flat facets and a finite period do to the figures of a simulation.

Errors of the mesh fall with the square of its cells. Two meshes of the same fields, under the same
rays, tell how large they are, and so what a mesh without them would give (L. F. Richardson & J. A.
Gaunt, The deferred approach to the limit, Phil. Trans. R. Soc. A 226, 1927); a third one, coarser
still, tells whether that law holds for the cells at hand. The period is judged by a law that was
measured beforehand, since fields of different periods have nothing in common.
"""

from itertools import pairwise

import numpy as np

from msbsdf_cli.statistics.binning import PHI_BINS, THETA_BINS, lobe_axes, merge_bins
from msbsdf_cli.statistics.tally import Tally, combination
from surfaces.facet import Array

SAFETY = 3
"""Error of a mesh, at most, over what two meshes say of it (P. J. Roache, Perspective: a method for
uniform reporting of grid refinement studies, J. Fluids Eng. 116, 1994)."""

FEWEST_ON_ALL = 8
"""Realisations that are traced on the coarser meshes too, or all if they are fewer; of many, half.
"""


def on_all_meshes(realisations: int) -> int:
    """How many realisations are traced on the coarser meshes as well."""
    return min(realisations, max(FEWEST_ON_ALL, realisations // 2))


def moved_by_period(extent: float) -> float:
    """Light that a period of so many correlation lengths moves, at most, between the first order
    and the later ones.

    What grazing light meets again falls off exponentially, and what a finite number of waves does
    to heights and slopes with the number of waves. Measured with mirrors of alpha 0.5 and 1, theta
    0, 1 and 1.5, against periods of 16 with noise of .0003: .0094, .0031 and .0008 at most for 4,
    6 and 8 correlation lengths.
    """
    return 0.11 * float(np.exp(-0.615 * extent)) + 0.03 / extent**2


def meshes(cells: int, extent: int) -> tuple[int, int]:
    """Cells of the two coarser meshes, a half and a quarter or a little less: such that a period
    has an even number of them."""
    step = 1 + extent % 2
    half, quarter = (max(cells // part // step, 1) * step for part in (2, 4))
    return half, quarter


def extrapolated(
    cells: tuple[int, int, int], fine: Tally, middle: Tally, coarse: Tally
) -> tuple[Tally, Tally]:
    """From units of the same rays on meshes of so many cells, the finest first: what a mesh without
    errors would have more than the first, and how far that is from what the other two say.
    """
    a, b = (_weight(*pair) for pair in pairwise(cells))
    more = combination((a, fine), (-a, middle))
    return more, combination((1 + a, fine), (-a - 1 - b, middle), (b, coarse))


def _weight(cells: int, coarser: int) -> float:
    """Error of a mesh over what it has less than a coarser one."""
    return 1 / ((cells / coarser) ** 2 - 1) if cells > coarser else 0.0


def squared_errors(tally: Tally, value: Array, more: Tally, doubt: Tally, extent: float) -> Array:
    """Squares of the errors of cells and period in `value`, a row of figures of `tally`.

    `more` and `doubt` are sums of what `extrapolated` gives. The mesh's error is taken to be as
    large as the step to a mesh without errors where the coarsest mesh bears it out, and `SAFETY`
    times as large where that one is too coarse for the law.
    """
    (step, step_noise), (off, off_noise) = more.figures(), doubt.figures()
    # Squares without their noise, which is no error of the mesh, but hides what may be one.
    least, most = np.maximum(step**2 - step_noise, 0), np.maximum(step**2, step_noise)
    errors = np.clip(off**2 - off_noise, least, SAFETY**2 * most)
    squares, values = tally.views(errors), tally.views(value)
    moved = _relative_error_by_period(values["energy"], extent)
    squares["energy"][...] += (moved * values["energy"]) ** 2
    squares["moments"][...] += (moved[..., None] * values["moments"]) ** 2
    squares["sequence"][...] += (moved.max() * values["sequence"]) ** 2
    for name in ("side", "absorbed"):
        # Nothing is moved where all the light is, or none.
        squares[name][...] += moved.max() ** 2 * values[name] * np.maximum(1 - values[name], 0)
    relative = _relative_lobe_error(values["lobe"], more) ** 2 + moved**2
    squares["lobe"][...] = relative[..., None] * values["lobe"] ** 2
    return errors


def _relative_lobe_error(lobe: Array, more: Tally) -> Array:
    """Root mean square error of each order's lobe by the mesh over its root mean square, (order,
    side), in merged bins: in single ones noise would drown it."""
    solid_angle = merge_bins(np.repeat(lobe_axes()[2][:, None], PHI_BINS, axis=1))
    apart = more.estimate("lobe")
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


def _relative_error_by_period(energy: Array, extent: float) -> Array:
    """Relative error (order, 1) by the period of each order's light, from energies (order, side):
    what is moved between the first order and the later ones is shared in proportion."""
    first, later = energy[0].sum(), energy[1:].sum()
    moved = min(moved_by_period(extent), first, later)
    relative = np.full((len(energy), 1), moved / later if later > 0 else 0.0)
    relative[0] = moved / first if first > 0 else 0.0
    return relative
