"""Points that were not measured: counted, and filled where they are few."""

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.sparse import csr_array
from scipy.sparse.linalg import cg

from surfaces.facet import Array
from surfaces.files._scan import FileError

MOST_MISSING = 0.1
"""Share of the points above which a scan is refused: what is filled in is smoother than what was
not measured, and steep flanks are what instruments lose first."""

PRECISE = 1e-6
"""Of the fill, relative to the heights around."""


def filled(heights: Array) -> tuple[Array, tuple[str, ...]]:
    """Heights without NaN, and sentences on what was filled in.

    Each filled height is the mean of its neighbours, as a soap film over the hole has it (the
    discrete Laplace equation). Raises FileError where too many are missing.
    """
    missing = np.isnan(heights)
    count = int(np.count_nonzero(missing))
    if count == 0:
        return heights, ()
    if count > MOST_MISSING * heights.size:
        raise FileError(
            f"{count} of its {heights.size} points are missing, more than the "
            f"{MOST_MISSING:.0%} that are filled in"
        )
    # From the nearest point on, only what lies within holes is left to solve for.
    nearest = distance_transform_edt(missing, return_distances=False, return_indices=True)
    full: Array = heights[tuple(nearest)]
    full[missing] = _film(full, missing)
    return full, (f"{count} of {heights.size} points were missing and have been filled in",)


def _film(full: Array, missing: Array) -> Array:
    """Heights of the missing points, each the mean of its two to four neighbours."""
    i, j = np.nonzero(missing)
    number = np.full(missing.shape, -1)
    number[i, j] = np.arange(i.size)
    rows, columns, known, degree = [], [], np.zeros(i.size), np.zeros(i.size)
    for di, dj in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        ni, nj = i + di, j + dj
        inside = (ni >= 0) & (ni < full.shape[0]) & (nj >= 0) & (nj < full.shape[1])
        at = np.flatnonzero(inside)
        other = number[ni[at], nj[at]]
        degree[at] += 1
        rim = other < 0
        known[at[rim]] += full[ni[at[rim]], nj[at[rim]]]
        rows.append(at[~rim])
        columns.append(other[~rim])
    row, column = np.concatenate(rows), np.concatenate(columns)
    diagonal = np.arange(i.size)
    values = np.concatenate([-np.ones(row.size), degree])
    places = np.concatenate([row, diagonal]), np.concatenate([column, diagonal])
    matrix = csr_array((values, places), shape=(i.size, i.size))
    film, _ = cg(matrix, known, x0=full[i, j], rtol=PRECISE)
    return np.asarray(film)
