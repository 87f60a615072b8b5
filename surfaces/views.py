"""The eight surfaces that one mesh is: turned by quarters of a circle, and each turned over.

A random field is as likely as itself turned or upside down, so that each view is a surface like any
other. They are not independent, and count as one. But light comes from other azimuths, and from
below it meets other facets: the mean over all eight is about as good as that over eight surfaces,
of which making the mesh costs most.

A view is a matrix, and so is the way from the world to the grid: their product takes vectors of the
world to the mesh at once.
"""

import numpy as np

from surfaces.facet import Array
from surfaces.stretch import Stretch

VIEWS = 8
"""0 to 3: turned by so many quarters; 4 to 7: the same, upside down."""
UPRIGHT = 4
"""Of these, as many are of a field that is not the same upside down."""

COS, SIN = np.array([[1.0, 0.0, -1.0, 0.0] * 2, [0.0, 1.0, 0.0, -1.0] * 2])
SIDE = np.array([1.0] * 4 + [-1.0] * 4)
TURNS = np.zeros((VIEWS, 3, 3))
"""From the grid as each view sees it to the mesh; all are orthogonal."""
TURNS[:, 0, 0], TURNS[:, 0, 1], TURNS[:, 1, 0], TURNS[:, 1, 1] = COS, -SIN, SIN, COS
TURNS[:, 2, 2] = SIDE


def upside_down(view: Array) -> Array:
    """Which views (n,) have the mesh turned over."""
    return np.asarray(view >= VIEWS // 2)


class Views:
    """The way between a world, which `stretch` takes to the grid, and the first `number` of the
    surfaces that a mesh is."""

    def __init__(self, stretch: Stretch, number: int = VIEWS) -> None:
        turns = TURNS[:number]
        self.to_mesh = turns @ stretch.matrix
        """From the world to the mesh, a matrix for each view, (views, 3, 3)."""
        self.slopes = -turns[:, 2:, 2:] * self.to_mesh[:, :2, :2].transpose(0, 2, 1)
        """From slopes of the mesh to the first two components of upward normals, (views, 2, 2)."""

    def normals(self, slopes: Array, view: Array | None) -> Array:
        """Upward normals (3, n) in the world, of z = 1, of planes of these slopes (2, n) a cell."""
        m = np.empty((3, slopes.shape[1]), slopes.dtype)
        each(self.slopes, slopes, view, m[:2])
        m[2] = 1
        return m


def each(matrices: Array, vectors: Array, view: Array | None, out: Array | None = None) -> Array:
    """Vectors (k, n), each multiplied by the matrix of its view, of `matrices` (views, j, k), in
    the precision of the vectors.

    The numbers of the views `view` (n,) ascend; None: all are of the first.
    """
    matrices = matrices.astype(vectors.dtype, copy=False)
    if out is None:
        out = np.empty((matrices.shape[1], vectors.shape[1]), vectors.dtype)
    if view is None:
        return np.matmul(matrices[0], vectors, out=out)
    ends = np.searchsorted(view, np.arange(VIEWS + 1, dtype=view.dtype)).tolist()
    for matrix, start, end in zip(matrices, ends, ends[1:], strict=False):
        if end > start:
            np.matmul(matrix, vectors[:, start:end], out=out[:, start:end])
    return out
