"""A heightfield as a triangle mesh in an Embree scene, with the exact plane of each triangle.

The mesh has its own coordinates: one cell of the grid is 1 along u and v, heights are 1 standard
deviation. Grid points are then integers, exact in the single precision of Embree, and one scene
serves every roughness: `Surface.stretch` turns directions into them.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from surfaces.facet import Array
from surfaces.heightfield import shortened
from surfaces.marginal import GAUSSIAN_HEIGHTS, Marginal
from surfaces.spectrum import GAUSSIAN, Spectrum
from surfaces.stretch import Stretch

if TYPE_CHECKING:
    from trimesh import Trimesh

MARGIN = 1
"""Cells meshed beyond each side of the period, so that no hit is ever sought at the mesh's rim."""


@dataclass
class Surface:
    """A periodic heightfield, heights (nu, nv) over `cells` cells a unit of length.

    Raises ValueError where either is odd: the triangles of both ends would not fit together.
    """

    heights: Array
    cells: int
    rays: int = 0
    """Rays asked of Embree so far, and the seconds it took."""
    embree_s: float = 0.0
    spectrum: Spectrum = GAUSSIAN
    """Of a random field: how much of its slopes facets have."""
    marginal: Marginal = GAUSSIAN_HEIGHTS
    """Of a random field: how its heights are distributed."""

    def __post_init__(self) -> None:
        for period in (n for n in self.heights.shape if n % 2):
            raise ValueError(f"a period of {period} cells is odd: an even number is wanted.")
        # Embree's precision, so that its triangles and the planes below are the same.
        self.heights = self.heights.astype(np.float32).astype(np.float64)

    @cached_property
    def period(self) -> Array:
        """Cells in a period, along each axis, (2, 1)."""
        return np.array(self.heights.shape, float)[:, None]

    def stretch(self, alpha_x: float, alpha_y: float, phi: float | None = None) -> Stretch:
        """From the world's coordinates to the grid's, for a roughness and, turned so that the
        period matters least, for light of azimuth `phi`."""
        extent = len(self.heights) / self.cells
        per_length = shortened(self.cells, extent, self.spectrum, self.marginal)
        return Stretch.of(alpha_x / 2 * per_length, alpha_y / 2 * per_length, phi)

    @cached_property
    def top(self) -> float:
        """Height of the highest point."""
        return float(self.heights.max())

    @cached_property
    def bottom(self) -> float:
        """Height of the lowest point."""
        return float(self.heights.min())

    @cached_property
    def _grid(self) -> Array:
        return np.pad(self.heights, ((MARGIN, MARGIN + 1), (MARGIN, MARGIN + 1)), mode="wrap")

    @cached_property
    def planes(self) -> Array:
        """Planes (triangles, 4) of the triangles: z = plane[0] + plane[1] u + plane[2] v. A fourth
        number, 0, makes rows of 32 bytes, which are taken twice as fast."""
        h = self._grid
        rows, columns = h.shape[0] - 1, h.shape[1] - 1
        along_u, along_v = np.diff(h, axis=0), np.diff(h, axis=1)
        left, right = along_v[:-1], along_v[1:]
        # One array for each number of a plane first: what lies together is written fast.
        offset, slope_u, slope_v, _ = parts = np.zeros((4, 2, rows, columns))
        slope_u[0], slope_u[1] = along_u[:, :-1], along_u[:, 1:]
        slope_v[0], slope_v[1] = right, left
        for odd in (np.s_[::2, 1::2], np.s_[1::2, ::2]):
            slope_v[0][odd], slope_v[1][odd] = left[odd], right[odd]
        # Each triangle has the corner (1, 0) or (0, 1) of its cell: the first and the second.
        u = np.arange(rows)[:, None] - float(MARGIN)
        v = np.arange(columns) - float(MARGIN)
        offset[0] = h[1:, :-1] - slope_u[0] * (u + 1) - slope_v[0] * v
        offset[1] = h[:-1, 1:] - slope_u[1] * u - slope_v[1] * (v + 1)
        return np.ascontiguousarray(parts.reshape(4, 2, -1).transpose(2, 1, 0)).reshape(-1, 4)

    def slopes(self, every: int) -> Array:
        """Slopes (2, n), per cell, of one triangle in every so many cells of a period, each way."""
        nu, nv = self.heights.shape
        cells = self.planes.reshape(nu + 2 * MARGIN, nv + 2 * MARGIN, 2, 4)
        cells = cells[MARGIN : MARGIN + nu, MARGIN : MARGIN + nv]
        return np.ascontiguousarray(cells[::every, ::every, 0, 1:3].reshape(-1, 2).T)

    def triangles(self, chosen: Array) -> tuple[Array, Array]:
        """Corners (corner, xyz, n) and planes (3, n) of the triangles of these numbers (n,)."""
        columns = self._grid.shape[1]
        vertex = corner_vertices(chosen, columns)
        u, v = np.divmod(vertex, columns)
        corners = np.stack([u - MARGIN, v - MARGIN, self._grid.ravel()[vertex]])
        planes = self.planes.take(chosen, axis=0).T[:3]
        return np.ascontiguousarray(corners.transpose(2, 0, 1)), np.ascontiguousarray(planes)

    def _within_period(self, cells: Array) -> Array:
        """Numbers of the triangles in the cells (nu, nv) of one period that are True."""
        padded = np.pad(cells, MARGIN)
        return (2 * np.flatnonzero(padded)[:, None] + [0, 1]).ravel()

    @property
    def period_triangles(self) -> tuple[Array, Array]:
        """Corners (corner, xyz, triangles) and planes (3, triangles) of one period's triangles."""
        return self.triangles(self._within_period(np.ones(self.heights.shape, bool)))

    def crossing(self, height: float) -> tuple[Array, Array]:
        """The same of the triangles of a period in those of its cells that cross a height."""
        lowest, highest = self._cell_range
        return self.triangles(self._within_period((lowest < height) & (height < highest)))

    @cached_property
    def _cell_range(self) -> tuple[Array, Array]:
        """Lowest and highest corner of each cell of a period, (nu, nv)."""
        h = self._grid[MARGIN:-MARGIN, MARGIN:-MARGIN]
        low, high = np.minimum(h[1:], h[:-1]), np.maximum(h[1:], h[:-1])
        return np.minimum(low[:, 1:], low[:, :-1]), np.maximum(high[:, 1:], high[:, :-1])

    @cached_property
    def lift(self) -> float:
        """How far above its facet a ray starts again.

        Single precision moves an origin by at most half a spacing along each axis, hence, on the
        steepest facet, by this height at most; twice that, since Embree rounds once more.
        """
        spacing_uv = np.spacing(np.float32(self.period.max() + 2 * MARGIN))
        spacing_z = np.spacing(np.float32(max(self.top, -self.bottom)))
        steepest = (np.abs(self.planes[:, 1]) + np.abs(self.planes[:, 2])).max()
        return float(spacing_uv * steepest + spacing_z)

    @cached_property
    def scene(self) -> EmbreeScene:
        """The Embree scene of one period and its margins."""
        h = self._grid
        u, v = ((np.arange(n) - float(MARGIN)).astype(object) for n in h.shape)
        # Python's own numbers, for the reason that `_tuples` gives.
        vertices = np.empty((*h.shape, 3), object)
        vertices[..., 0], vertices[..., 1], vertices[..., 2] = u[:, None], v, h
        # `robust`: rays along the lines of the mesh slip through otherwise.
        scene = EmbreeScene(robust=True)
        TriangleMesh(scene, vertices.reshape(-1, 3), _tuples(*h.shape))
        return scene

    def build(self) -> None:
        """Make all that rays need: Embree builds its tree in the first call, of no use else."""
        self.query(np.zeros((3, 1)), np.ones((3, 1)))
        self.rays, self.embree_s = 0, 0.0
        _ = self.lift

    def query(self, o: Array, d: Array) -> Array:
        """Numbers (n,) of the triangles that rays (3, n) meet first within the mesh, or -1."""
        o, d = o.astype(np.float32, copy=False), d.astype(np.float32, copy=False)
        # A sum of products is finite only where all of them are.
        if not np.isfinite(np.vdot(o, d)):
            raise FloatingPointError("a ray with a value that is not finite was about to be traced")
        started = perf_counter()
        triangle: Array = self.scene.run(o.T, d.T, query="INTERSECT")
        self.embree_s += perf_counter() - started
        self.rays += o.shape[1]
        return triangle

    def mesh(self, stretch: Stretch) -> "Trimesh":
        """One period, in units of the heights' standard deviation."""
        # Not above: it takes longer to import than many a run of a library's user takes.
        import trimesh

        h = np.pad(self.heights, (0, 1), mode="wrap")
        u, v = np.meshgrid(*(np.arange(n, dtype=float) for n in h.shape), indexing="ij")
        vertices = stretch.to_world(np.stack([u, v, h]).reshape(3, -1))
        return trimesh.Trimesh(vertices.T, faces(*h.shape), process=False, validate=False)


def corner_vertices(triangles: Array, columns: int) -> Array:
    """Vertex numbers (n, 3) of the triangles of these numbers (n,), on a grid of so many points a
    row.

    The diagonals alternate like the fields of a chessboard, since a diagonal that always ran the
    same way would make slopes along x and y correlate.
    """
    cell, second = np.divmod(triangles, 2)
    i, j = np.divmod(cell, columns - 1)
    corner, odd = i * columns + j, (i + j) & 1
    first = corner + columns * (second & odd)
    last = corner + 1 + columns * (1 - (second | odd))
    return np.stack([first, corner + columns + second, last], 1)


def faces(rows: int, columns: int) -> Array:
    """Vertex numbers (2 (rows - 1) (columns - 1), 3) of the triangles of a grid of points."""
    number = np.arange(2 * (rows - 1) * (columns - 1))
    return corner_vertices(number, columns).astype(np.int32)


@lru_cache(maxsize=3)
def _tuples(rows: int, columns: int) -> Array:
    """`faces` as tuples of Python's integers (triangles,), kept for all surfaces of a size.

    Embree's binding asks for numbers one by one, as `faces[i][j]`, which costs most of making a
    surface: less than half where no row and no number has to be made into an object first.
    """
    numbers = np.arange(rows * columns).astype(object)
    found = np.empty(2 * (rows - 1) * (columns - 1), object)
    found[:] = list(zip(*numbers[faces(rows, columns).T].tolist(), strict=True))
    return found
