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
        along = d.take(seeking, axis=1)
        start = _at_the_rim(surface, o.take(seeking, axis=1), along)
        above, under = start[2] >= surface.top, start[2] < surface.bottom
        sky = above if inside is None else above ^ inside.take(seeking)
        triangle[seeking] = AWAY.take(sky)
        on = np.flatnonzero(~(above | under))
        if on.size < seeking.size:
            seeking, start, along = (a.take(on, axis=-1) for a in (seeking, start, along))
        if seeking.size:
            for whole, some in zip(o, start, strict=True):
                whole[seeking] = some
            found = surface.query(start, along)
            triangle[seeking] = found
            seeking = seeking.compress(found < 0)
    triangle[seeking] = LOST
    return triangle


def _at_the_rim(surface: Surface, o: Array, d: Array) -> Array:
    """Where rays (3, n) that met nothing leave the period, as points of the next, (3, n).

    The mesh reaches a margin beyond the period, so the way to the period's rim, and a little of
    what follows, has been searched. A ray straight up or down reaches no side, at an infinite
    height.
    """
    beyond = np.copysign(surface.period.astype(o.dtype), d[:2])
    # Of a ray along the rim 0 / 0: the other side is nearer.
    with np.errstate(divide="ignore", invalid="ignore"):
        to_rim = (np.maximum(beyond, 0) - o[:2]) / d[:2]
        nearest = np.fmin.reduce(to_rim, axis=0, initial=np.inf)
        point = o + nearest * d
        point[:2] -= beyond * (to_rim == nearest)
    return point


def meet(surface: Surface, o: Array, d: Array, triangle: Array) -> tuple[Array, Array, Array]:
    """Where rays (3, n) meet the planes of their triangles (n,), in double precision.

    Returns points (3, n) within one period, whether the upper side is met (n,), and the slopes
    (2, n) of the planes, in the surface's coordinates.
    """
    o, d = o.astype(float, copy=False), d.astype(float, copy=False)
    offset, slope_u, slope_v, _ = planes = surface.planes.take(triangle, axis=0).T
    approach = d[2] - slope_u * d[0] - slope_v * d[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (offset + slope_u * o[0] + slope_v * o[1] - o[2]) / approach
        point = o + distance * d
    # The rest of a division by floor costs a fifth of the modulo's.
    point[:2] -= surface.period * np.floor(point[:2] * (1 / surface.period))
    return point, approach < 0, planes[1:3]
