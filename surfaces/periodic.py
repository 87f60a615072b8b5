"""What a ray meets on a surface that goes on for ever: period after period, until facet or sky."""

import numpy as np

from surfaces.facet import Array
from surfaces.surface import Surface

ESCAPED = -1
"""What rays meet that leave towards the sky; of no triangle Embree says the same."""
LOST = -2
"""Of rays that leave towards the other side of the surface, or cross too many periods."""

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
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(MAX_PERIODS):
            if seeking.size == 0:
                return triangle
            along = d.take(seeking, axis=1)
            start = _at_the_rim(surface, o.take(seeking, axis=1), along)
            # A ray beyond the highest point that comes down is still to meet the surface.
            above = (start[2] >= surface.top) & (along[2] >= 0)
            under = (start[2] < surface.bottom) & (along[2] <= 0)
            away = above | under
            # Embree has found nothing: that some leave the wrong way has to be told.
            astray = under if inside is None else away & (under ^ inside.take(seeking))
            if astray.any():
                triangle[seeking.compress(astray)] = LOST
            on = np.flatnonzero(~away)
            if on.size == 0:
                return triangle
            if on.size < seeking.size:
                seeking, start, along = (a.take(on, axis=-1) for a in (seeking, start, along))
            for whole, some in zip(o, start, strict=True):
                whole[seeking] = some
            triangle[seeking] = found = surface.query(start, along)
            seeking = seeking.compress(found < 0)
    triangle[seeking] = LOST
    return triangle


def _at_the_rim(surface: Surface, o: Array, d: Array) -> Array:
    """Where rays (3, n) that met nothing leave the period, as points of the next, (3, n).

    The mesh reaches a margin beyond the period, so the way to the period's rim, and a little of
    what follows, has been searched. A ray straight up or down reaches no side, at an infinite
    height. Of a ray along a side 0 / 0 says that the other one is nearer. Heights are in double
    precision: light near the horizon falls little with each period.
    """
    beyond = np.copysign(surface.period, d[:2])
    to_rim = (np.maximum(beyond, 0) - o[:2]) / d[:2]
    nearest = np.fmin(to_rim[0], to_rim[1])
    point = o + nearest * d
    point[:2] -= beyond * (to_rim == nearest)
    return point


def meet(surface: Surface, o: Array, d: Array, triangle: Array) -> tuple[Array, Array, Array]:
    """Where rays (3, n) meet the planes of their triangles (n,), in double precision.

    Returns points (3, n) within one period, whether the upper side is met (n,), and the slopes
    (2, n) of the planes, in the surface's coordinates.
    """
    d = d.astype(float, copy=False)
    offset, slope_u, slope_v, _ = planes = surface.planes.take(triangle, axis=0).T
    approach = d[2] - slope_u * d[0] - slope_v * d[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (offset + slope_u * o[0] + slope_v * o[1] - o[2]) / approach
        point = o + distance * d
    # The rest of a division by floor costs a fifth of the modulo's.
    point[:2] -= surface.period * np.floor(point[:2] * (1 / surface.period))
    return point, approach < 0, planes[1:3]
