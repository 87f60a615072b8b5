"""The eight surfaces that one mesh is: turned by quarters of a circle, and each turned over.

A random field is as likely as itself turned or upside down, so that each view is a surface like any
other. They are not independent, and count as one. But light comes from other azimuths, and from
below it meets other facets: the mean over all eight is about as good as that over eight surfaces,
of which making the mesh costs most.
"""

import numpy as np

from surfaces.facet import Array

VIEWS = 8
"""0 to 3: turned by so many quarters; 4 to 7: the same, upside down."""

COS = np.array([1.0, 0.0, -1.0, 0.0] * 2)
SIN = np.array([0.0, 1.0, 0.0, -1.0] * 2)
SIDE = np.array([1.0] * 4 + [-1.0] * 4)


def upside_down(view: Array) -> Array:
    """Which views (n,) have the mesh turned over."""
    return np.asarray(view >= VIEWS // 2)


def to_mesh(d: Array, view: Array) -> Array:
    """Vectors (3, n) of the grid, as each view (n,) sees it, in the coordinates of the mesh."""
    cos, sin = COS.take(view), SIN.take(view)
    return np.stack([cos * d[0] - sin * d[1], sin * d[0] + cos * d[1], SIDE.take(view) * d[2]])


def to_view(d: Array, view: Array) -> Array:
    """The way back from `to_mesh`."""
    cos, sin = COS.take(view), SIN.take(view)
    return np.stack([cos * d[0] + sin * d[1], cos * d[1] - sin * d[0], SIDE.take(view) * d[2]])


def slopes_in_view(slopes: Array, view: Array) -> Array:
    """Slopes (2, n) of planes of the mesh as each view (n,) has them."""
    cos, sin, side = COS.take(view), SIN.take(view), SIDE.take(view)
    return np.stack(
        [side * (cos * slopes[0] + sin * slopes[1]), side * (cos * slopes[1] - sin * slopes[0])]
    )
