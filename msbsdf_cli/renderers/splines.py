"""Cubic splines over regular grids of any dimension, as sums of uniform B-splines.

A table's nodes are at the integers. Renderers have the same sums as cubic filters of textures, of
coefficients in place of the values.
"""

import numpy as np
from scipy.ndimage import map_coordinates

from surfaces.facet import Array

REACH = 12
"""Nodes beyond an end that a spline's coefficients there feel: those beyond count 0.27^12 or less,
a ten-millionth."""

MARGIN = 1
"""Coefficients beyond either end of the nodes."""


def coefficients(values: Array, axis: int) -> Array:
    """Of the spline through `values`, with `MARGIN` more at either end of the axis, in whose first
    and last two intervals it is one cubic ("not a knot"). At least 5 values are needed."""
    n = values.shape[axis]
    through, rows = np.zeros((n + 2, n + 2)), np.arange(n)
    for offset, weight in enumerate((1 / 6, 2 / 3, 1 / 6)):
        through[rows, rows + offset] = weight
    through[n, :5] = through[n + 1, -5:] = (1, -4, 6, -4, 1)
    ends = [(0, 0)] * values.ndim
    ends[axis] = (0, 2)
    solved = np.linalg.solve(through, np.moveaxis(np.pad(values, ends), axis, 0).reshape(n + 2, -1))
    shape = np.moveaxis(values, axis, 0).shape[1:]
    return np.moveaxis(solved.reshape(n + 2, *shape), 0, axis)


def spline(coefficients: Array, places: tuple[Array, ...]) -> Array:
    """The spline at places (n,) along each axis, in nodes."""
    found: Array = map_coordinates(
        coefficients, [p + MARGIN for p in places], order=3, mode="nearest", prefilter=False
    )
    return found
