"""Free paths on an explicit surface: from points at a given height to the next facet.

Points are uniform over the part of the mean plane where the surface has that height and faces the
direction of travel. Where a plane crosses a height, that part is a line, and its weight is the
line's length over the slope: no band of heights is needed, and none biases the result.
"""

from typing import NamedTuple

import numpy as np

from surfaces.facet import Array
from surfaces.periodic import ESCAPED, meet, next_triangle
from surfaces.stretch import Stretch
from surfaces.surface import Surface
from surfaces.tracing import BLOCK, morton


class FreePaths(NamedTuple):
    """Where rays from one height, in one direction, met the surface again."""

    heights: Array
    """Heights of the facets met."""
    escaped: int
    lost: int
    weight: float
    """Measure of the points of departure; 0 where no point of that height faces the direction."""


def next_heights(
    surface: Surface, stretch: Stretch, d: Array, start: float, n: int, rng: np.random.Generator
) -> FreePaths:
    """Heights of the facets that `n` rays in direction `d` (3,) meet next.

    `stretch` is that of the surface for the roughness. `start` is the height of departure, or
    infinite for rays that arrive from outside.
    """
    travel = stretch.to_grid(d[:, None])
    if np.isinf(start):
        origins = np.empty((3, n))
        origins[:2] = morton((np.arange(n) + rng.random(n)) / n) * surface.period
        origins[2] = surface.top
        weight = 1.0
    else:
        origins, weight = level_points(surface, start, travel, n, rng)
    heights, escaped, lost = [np.zeros(0)], 0, 0
    for first in range(0, origins.shape[1], BLOCK):
        o = origins[:, first : first + BLOCK].copy()
        along = np.broadcast_to(travel, o.shape)
        triangle = next_triangle(surface, o, along, None)
        hit = triangle >= 0
        point, facing, _ = meet(surface, o[:, hit], along[:, hit], triangle[hit])
        heights.append(point[2, facing])
        escaped += int(np.count_nonzero(triangle == ESCAPED))
        lost += int(np.count_nonzero(~facing) + np.count_nonzero(triangle < ESCAPED))
    return FreePaths(np.concatenate(heights), escaped, lost, weight)


def level_points(
    surface: Surface, height: float, d: Array, n: int, rng: np.random.Generator
) -> tuple[Array, float]:
    """`n` points (3, n), lifted off the surface, of that height, on facets that face along `d`
    (3, 1), and their measure; none, where there is no such facet."""
    corners, planes = surface.period_triangles
    z = corners[:, 2]
    facing = planes[1] * d[0] + planes[2] * d[1] < d[2]
    crossing = np.flatnonzero(facing & (z.min(axis=0) < height) & (height < z.max(axis=0)))
    if crossing.size == 0:
        return np.empty((3, 0)), 0.0
    ends = _segment(corners[..., crossing], height)
    length = np.hypot(*(ends[1] - ends[0]))
    slope = np.hypot(*planes[1:, crossing])
    total = np.cumsum(length / slope)
    place = (np.arange(n) + rng.random(n)) / n * total[-1]
    chosen = np.minimum(np.searchsorted(total, place), total.size - 1)
    part = rng.random(n)
    points = np.empty((3, n))
    points[:2] = ends[0][:, chosen] * (1 - part) + ends[1][:, chosen] * part
    points[2] = height + surface.lift
    return points, float(total[-1])


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
