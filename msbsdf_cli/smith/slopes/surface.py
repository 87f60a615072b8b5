"""The slopes of a surface that is given, as its facets have them: no formula, a table.

Slopes, each over its roughness, are counted in cells of a grid, fine about 0 and coarser towards
the steepest, and their density is taken to be constant in a cell. All else follows from that
density: the projected area by integrating it, visible normals by rejection.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from msbsdf_cli.smith.slopes._distribution import Slopes, stretched
from msbsdf_cli.smith.slopes._visible_cells import VisibleCells
from surfaces.facet import Array

SIDE = 64
"""Cells along either axis."""

FINE = 1.5
"""Slope, over roughness, up to which cells are about equally wide."""

AZIMUTHS, HEIGHTS = 512, 512
"""Directions in which the projected area is tabulated; linear between them it is right to 1e-5 of
the roughness."""


@dataclass(frozen=True)
class Surface(Slopes):
    """Slopes counted in cells. `Surface.of(slopes)` counts those of facets.

    The cells are shifted and scaled, such that slopes have mean 0 and, as with Beckmann's
    distribution, the variance alpha^2 / 2 along each axis. Raises ValueError for cells that are
    none.
    """

    cells: tuple[int, ...] = ()
    """Numbers, i SIDE + j, of the cells that hold slopes."""
    shares: tuple[float, ...] = ()
    """Their shares of the facets, over the mean plane."""
    reach: float = 1.0
    """Slope, over its roughness, where the grid ends."""

    def __post_init__(self) -> None:
        super().__post_init__()
        number, share = np.array(self.cells, int), np.array(self.shares, float)
        if number.size == 0 or number.shape != share.shape or not (share > 0).all():
            raise ValueError("a surface's slopes are cells, each with a share above 0.")
        if number.min() < 0 or number.max() >= SIDE**2 or not 0 < self.reach < np.inf:
            raise ValueError(f"the cells of a surface's slopes are from 0 to {SIDE**2 - 1}.")

    @classmethod
    def of(cls, slopes: Array) -> "Surface":
        """From slopes (2, ...) of facets, all of one area over the mean plane.

        Raises ValueError where they have no spread.
        """
        slopes = slopes.reshape(2, -1)
        slopes = slopes - slopes.mean(axis=1, keepdims=True)
        alpha_x, alpha_y = np.sqrt(2 * (slopes**2).mean(axis=1)).tolist()
        if not min(alpha_x, alpha_y) > 0:
            raise ValueError("slopes along one axis are all the same: that is no rough surface.")
        scaled = slopes / np.array([[alpha_x], [alpha_y]])
        # The outermost slopes are inside.
        reach = float(np.abs(scaled).max()) * (1 + 1e-9)
        edges = _edges(reach)
        i, j = (np.clip(np.searchsorted(edges, s) - 1, 0, SIDE - 1) for s in scaled)
        count = np.bincount(i * SIDE + j, minlength=SIDE**2)
        cells = np.flatnonzero(count)
        shares = count[cells] / count.sum()
        return _kept(alpha_x, alpha_y, tuple(cells.tolist()), tuple(shares.tolist()), reach)

    @cached_property
    def _boxes(self) -> tuple[Array, Array, Array]:
        """Shares (n,), lower corners (2, n) and sizes (2, n) of the cells, in slopes over their
        roughness, of mean 0 and variance 1/2."""
        share = np.array(self.shares) / np.sum(self.shares)
        number, edges = np.divmod(np.array(self.cells), SIDE), _edges(self.reach)
        low = np.stack([edges[k] for k in number])
        size = np.stack([edges[k + 1] for k in number]) - low
        middle = low + size / 2
        mean = middle @ share
        variance = (middle**2 + size**2 / 12) @ share - mean**2
        scale = 1 / np.sqrt(2 * variance)
        return share, (low - mean[:, None]) * scale[:, None], size * scale[:, None]

    def __reduce__(self) -> tuple[Any, ...]:
        """Handed to another process without its tables, which take megabytes, and are made there
        once for all work on the same slopes."""
        return _kept, (self.alpha_x, self.alpha_y, self.cells, self.shares, self.reach)

    @property
    def isotropic(self) -> bool:
        """Never: no count is."""
        return False

    def D(self, m: Array) -> Array:
        """Of the cell that the slope is in."""
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = -m[0] / (m[2] * self.alpha_x), -m[1] / (m[2] * self.alpha_y)
            density = self.slope_density(x, y) / (self.alpha_x * self.alpha_y * m[2] ** 4)
        return np.where(m[2] > 0, density, 0).astype(m.dtype, copy=False)

    @cached_property
    def _grid(self) -> tuple[Array, Array, Array]:
        """Edges (SIDE + 1,) along x and y, and densities (SIDE, SIDE), of scaled slopes."""
        share, low, size = self._boxes
        number, edges = np.divmod(np.array(self.cells), SIDE), _edges(self.reach)
        density = np.zeros((SIDE, SIDE))
        density[tuple(number)] = share / size.prod(axis=0)
        along = []
        for axis in (0, 1):
            scale = size[axis, 0] / (edges[number[axis][0] + 1] - edges[number[axis][0]])
            along.append(low[axis, 0] + scale * (edges - edges[number[axis][0]]))
        return along[0], along[1], density

    def slope_density(self, x: Array, y: Array) -> Array:
        edges_x, edges_y, density = self._grid
        i, j = np.searchsorted(edges_x, x) - 1, np.searchsorted(edges_y, y) - 1
        inside = (np.minimum(i, j) >= 0) & (np.maximum(i, j) < SIDE)
        return np.where(inside, density[np.clip(i, 0, SIDE - 1), np.clip(j, 0, SIDE - 1)], 0)

    def marginal_density(self, x: Array) -> Array:
        edges_x, edges_y, density = self._grid
        i = np.searchsorted(edges_x, x) - 1
        along = density @ np.diff(edges_y)
        return np.where((i >= 0) & (i < SIDE), along[np.clip(i, 0, SIDE - 1)], 0)

    def sigma(self, d: Array) -> Array:
        """s E[(X - a)+] of the slope X along the stretched direction, a = z / s, from a table; with
        a below 0, (X - a)+ = (-X + a)+ + X - a, and the mean of X is 0."""
        s, z, a = stretched(self, d)
        phi = np.arctan2(self.alpha_y * d[1], self.alpha_x * d[0])
        turned = np.where(z < 0, phi + np.pi, phi)
        with np.errstate(invalid="ignore"):
            place = np.abs(a) / (1 + np.abs(a))
        place = np.where(np.isnan(place), 1, place) * HEIGHTS
        area = s * _bilinear(self._areas, turned * (AZIMUTHS / (2 * np.pi)), place)
        return (area + np.maximum(-z, 0)).astype(d.dtype, copy=False)

    @cached_property
    def _areas(self) -> Array:
        """E[(X - a)+], (AZIMUTHS + 1, HEIGHTS + 1): azimuths all the way round, and a / (1 + a)
        from 0 to 1."""
        share, low, size = self._boxes
        middle, half = low + size / 2, size / np.sqrt(12)
        # Two points along each side of a cell have its mean and its variance.
        signs = np.array([(p, q) for p in (-1, 1) for q in (-1, 1)])[..., None]
        x, y = (middle + signs * half).transpose(1, 0, 2).reshape(2, -1)
        weight = np.tile(share / 4, 4)
        place = np.arange(HEIGHTS)
        a = place / (HEIGHTS - place)
        table = np.zeros((AZIMUTHS + 1, HEIGHTS + 1))
        for k, phi in enumerate(2 * np.pi / AZIMUTHS * np.arange(AZIMUTHS)):
            along = np.cos(phi) * x + np.sin(phi) * y
            slope, w = along[along > 0], weight[along > 0]
            node = (slope / (1 + slope) * HEIGHTS).astype(int)
            # Sums over all slopes beyond each node.
            number, total = (
                np.bincount(node, v, HEIGHTS)[::-1].cumsum()[::-1] for v in (w, w * slope)
            )
            table[k, :-1] = total - a * number
        table[-1] = table[0]
        return np.maximum(table, 0)

    @cached_property
    def _visible(self) -> VisibleCells:
        return VisibleCells.of(*self._boxes)

    def visible_normals(self, wi: Array, n: int, rng: np.random.Generator) -> Array:
        dtype = wi.dtype.type
        s, z, _ = stretched(self, wi)
        phi = np.arctan2(self.alpha_y * wi[1], self.alpha_x * wi[0])
        s, z, phi = (np.broadcast_to(v, (n,)) for v in (s, z, phi))
        x, y = self._visible.slopes(s, z, phi, rng)
        m = np.empty((3, n), dtype)
        m[0], m[1], m[2] = -self.alpha_x * x, -self.alpha_y * y, 1
        return m


@lru_cache(maxsize=2)
def _kept(*values: Any) -> Surface:
    """The same object for the same slopes; a process that was forked has its tables already."""
    return Surface(*values)


def _edges(reach: float) -> Array:
    """Edges (SIDE + 1,) of cells from -reach to reach."""
    return FINE * np.sinh(np.arcsinh(reach / FINE) * np.linspace(-1, 1, SIDE + 1))


def _bilinear(table: Array, i: Array, j: Array) -> Array:
    """Values (n,) of a table between its nodes; periodic along the first axis."""
    rows, columns = table.shape[0] - 1, table.shape[1]
    i = i - rows * np.floor(i / rows)
    low_i = np.minimum(i.astype(np.intp), rows - 1)
    low_j = np.minimum(j.astype(np.intp), columns - 2)
    part_i, part_j, at = i - low_i, j - low_j, low_i * columns + low_j
    near = table.take(at) * (1 - part_j) + table.take(at + 1) * part_j
    at += columns
    return (
        near * (1 - part_i) + (table.take(at) * (1 - part_j) + table.take(at + 1) * part_j) * part_i
    )
