"""Free paths on an explicit surface: from points at a given height to the next facet.

Points are uniform over the part of the mean plane where the surface has that height and faces the
direction of travel. Where a plane crosses a height, that part is a line, and its weight is the
line's length over the slope: no band of heights is needed, and none biases the result.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from surfaces.facet import Array
from surfaces.periodic import ESCAPED, meet, next_triangle
from surfaces.surface import Surface
from surfaces.tracing import BLOCK, morton
from surfaces.views import SIDE, Views, upside_down


class FreePaths(NamedTuple):
    """Where rays from one height, in one direction, met the surface again."""

    heights: Array
    """Heights of the facets met."""
    shares: Array
    """Share of the points of departure that each of them stands for."""
    escaped: float
    """Share of those that met none."""
    lost: int
    weight: float
    """Measure of the points of departure; 0 where no point of that height faces the direction."""


class Level:
    """Where a mesh crosses a height."""

    def __init__(self, surface: Surface, height: float) -> None:
        self.surface, self.height = surface, height
        corners, planes = surface.crossing(height)
        z = corners[:, 2]
        crossing = np.flatnonzero((z.min(axis=0) < height) & (height < z.max(axis=0)))
        self.ends = _segment(corners[..., crossing], height)
        self.slopes = planes[1:, crossing]
        self.measure = np.hypot(*(self.ends[1] - self.ends[0])) / np.hypot(*self.slopes)

    def points(
        self,
        d: Array,
        n: int,
        rng: np.random.Generator,
        side: float = 1.0,
        piece: tuple[int, int] = (0, 1),
    ) -> tuple[Array, float]:
        """`n` points (3, n) off the mesh, on facets whose upper (`side` 1) or lower (-1) side faces
        along `d` (3,) of the mesh, and their measure; none, where there is no such facet. `piece`
        (i, 4^m) is where on the mesh, as `Tracer.trace` has it."""
        faces = side * (d[2] - self.slopes[0] * d[0] - self.slopes[1] * d[1]) > 0
        if piece[1] > 1:
            size = self.surface.period / np.sqrt(piece[1])
            corner = morton(np.array([piece[0] / piece[1]])) * self.surface.period
            place = (self.ends[0] + self.ends[1]) / 2 - corner
            faces &= ((place >= 0) & (place < size)).all(axis=0)
        facing = np.flatnonzero(faces)
        if facing.size == 0:
            return np.empty((3, 0)), 0.0
        total = np.cumsum(self.measure[facing])
        place = (np.arange(n) + rng.random(n)) / n * total[-1]
        chosen = facing[np.minimum(np.searchsorted(total, place), total.size - 1)]
        part = rng.random(n)
        points = np.empty((3, n))
        points[:2] = self.ends[0][:, chosen] * (1 - part) + self.ends[1][:, chosen] * part
        points[2] = self.height + side * self.surface.lift
        return points, float(total[-1])


@dataclass
class FreePathTracer:
    """Free paths on the surfaces that `views` makes of the mesh of `surface`."""

    surface: Surface
    views: Views
    levels: dict[float, Level] = field(default_factory=dict)

    def next_heights(
        self,
        d: Array,
        start: float,
        n: int,
        rng: np.random.Generator,
        piece: tuple[int, int] = (0, 1),
    ) -> FreePaths:
        """Heights of the facets that about `n` rays in direction `d` (3,) meet next, from the
        height `start`, infinite for rays that arrive from outside; they start on the `piece`
        (i, 4^m) of the mesh."""
        directions = (self.views.to_mesh @ d).T
        each = -(-n // directions.shape[1])
        parts = [
            self._departures(along, start, float(side), each, rng, piece)
            for along, side in zip(directions.T, SIDE, strict=False)
        ]
        measure = np.array([part[1] for part in parts])
        size = np.array([part[0].shape[1] for part in parts])
        view = np.repeat(np.arange(size.size), size)
        share = (measure / np.maximum(size, 1) / (measure.sum() or 1))[view]
        origins = np.concatenate([part[0] for part in parts], axis=1)
        heights, met, escaped, lost = [np.zeros(0)], [np.zeros(0)], 0.0, 0
        for first in range(0, view.size, BLOCK):
            block = slice(first, first + BLOCK)
            o, lower = origins[:, block].copy(), upside_down(view[block])
            travel = directions.take(view[block], axis=1)
            triangle = next_triangle(self.surface, o, travel, lower)
            hit = np.flatnonzero(triangle >= 0)
            o, travel = o.take(hit, axis=1), travel.take(hit, axis=1)
            point, upper, _ = meet(self.surface, o, travel, triangle.take(hit))
            facing = upper ^ lower.take(hit)
            heights.append((SIDE[view[block]].take(hit) * point[2]).compress(facing))
            met.append(share[block].take(hit).compress(facing))
            escaped += float(share[block][triangle == ESCAPED].sum())
            lost += int(np.count_nonzero(~facing) + np.count_nonzero(triangle < ESCAPED))
        found = np.concatenate(heights), np.concatenate(met)
        return FreePaths(*found, escaped, lost, float(measure.mean()))

    def _departures(
        self,
        along: Array,
        start: float,
        side: float,
        n: int,
        rng: np.random.Generator,
        piece: tuple[int, int],
    ) -> tuple[Array, float]:
        """Origins (3, n) of the mesh for one view, whose upper side is the mesh's upper (`side` 1)
        or lower one (-1), in the direction `along` (3,), and their measure."""
        if np.isinf(start):
            origins = np.empty((3, n))
            place = (np.arange(n) + rng.random(n)) / n
            origins[:2] = morton((piece[0] + place) / piece[1]) * self.surface.period
            origins[2] = self.surface.top if side > 0 else self.surface.bottom
            return origins, 1.0
        height = side * start
        if height not in self.levels:
            self.levels[height] = Level(self.surface, height)
        return self.levels[height].points(along, n, rng, side, piece)


def _segment(corners: Array, height: float) -> tuple[Array, Array]:
    """Ends (2, n) of the lines on which triangles (corner, xyz, n) have that height."""
    order = np.argsort(corners[:, 2], axis=0)[:, None, :]
    low, middle, high = np.take_along_axis(corners, order, axis=0)
    above_middle = height > middle[2]
    near = np.where(above_middle, middle, low)
    far = np.where(above_middle, high, middle)

    def at_height(a: Array, b: Array) -> Array:
        with np.errstate(invalid="ignore", divide="ignore"):
            share = (height - a[2]) / (b[2] - a[2])
        return a[:2] + np.nan_to_num(share) * (b[:2] - a[:2])

    return at_height(low, high), at_height(near, far)
