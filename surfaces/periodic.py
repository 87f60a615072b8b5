"""What a ray meets on a surface that goes on for ever: period after period, until facet or sky."""

import numpy as np

from surfaces.facet import Array
from surfaces.surface import Surface

ESCAPED = -1
LOST = -2
AWAY = np.array([LOST, ESCAPED], np.int32)
"""What rays are that have left towards the other side of the surface, and towards the sky."""

MAX_PERIODS = 10_000
"""Periods a ray may cross between two facets. Only rays within about 1e-5 of the horizontal cross
more; they count as lost, so as unresolved."""


def next_triangle(surface: Surface, o: Array, d: Array, inside: Array | None) -> Array:
    """Triangles (n,) that rays meet next, or `ESCAPED` from the surface, or `LOST`.

    `o`, `d` (3, n) are in the surface's coordinates, `inside` (n,) tells who is below the surface.
    `o` is changed: along the ray and by whole periods, into the period where the triangle is met.
    """
    triangle = surface.query(o, d)
    seeking = np.flatnonzero(triangle < 0)
    for _ in range(MAX_PERIODS):
        if seeking.size == 0:
            return triangle
        start, along = o.take(seeking, axis=1), d.take(seeking, axis=1)
        rim, to_rim, height = _rim(surface, start, along)
        above, under = height >= surface.top, height < surface.bottom
        sky = above if inside is None else above ^ inside.take(seeking)
        triangle[seeking] = AWAY.take(sky)
        on = np.flatnonzero(~(above | under))
        seeking = seeking.take(on)
        if seeking.size:
            start, along, rim, to_rim = (a.take(on, axis=1) for a in (start, along, rim, to_rim))
            start += to_rim.min(axis=0) * along
            over_u = to_rim[0] <= to_rim[1]
            for axis, over in ((0, over_u), (1, ~over_u)):
                np.copyto(start[axis], surface.period[axis] - rim[axis], where=over)
            for whole, some in zip(o, start, strict=True):
                whole[seeking] = some
            found = surface.query(start, along)
            triangle[seeking] = found
            seeking = seeking.compress(found < 0)
    triangle[seeking] = LOST
    return triangle


def _rim(surface: Surface, o: Array, d: Array) -> tuple[Array, Array, Array]:
    """Where rays that met nothing leave the period: its sides that they head for, along u and v
    (2, n), how far these are (2, n), and the height (n,) at which the nearer is reached.

    The mesh reaches a margin beyond the period, so the way to the period's rim, and a little of
    what follows, has been searched. A ray straight up or down reaches no side, at an infinite
    height.
    """
    rim = surface.period * (d[:2] > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        to_rim = (rim - o[:2]) / d[:2]
    to_rim[d[:2] == 0] = np.inf
    return rim, to_rim, o[2] + np.minimum(to_rim[0], to_rim[1]) * d[2]


def meet(surface: Surface, o: Array, d: Array, triangle: Array) -> tuple[Array, Array, Array]:
    """Where rays (3, n) meet the planes of their triangles (n,), in double precision.

    Returns points (3, n) within one period, whether the upper side is met (n,), and the slopes
    (2, n) of the planes, in the surface's coordinates.
    """
    offset, slope_u, slope_v, _ = planes = surface.planes.take(triangle, axis=0).T
    approach = d[2] - slope_u * d[0] - slope_v * d[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (offset + slope_u * o[0] + slope_v * o[1] - o[2]) / approach
        point = o + distance * d
    # The rest of a division by floor costs a fifth of the modulo's.
    point[:2] -= surface.period * np.floor(point[:2] * (1 / surface.period))
    return point, approach < 0, planes[1:3]
