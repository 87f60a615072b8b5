"""What a ray meets on a surface that goes on for ever: period after period, until facet or sky."""

import numpy as np

from surfaces.facet import Array
from surfaces.surface import Surface

ESCAPED = -1
LOST = -2

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
        across, away = _cross(surface, o.take(seeking, axis=1), d.take(seeking, axis=1))
        side = away if inside is None else np.where(inside[seeking], -away, away)
        triangle[seeking] = np.where(side > 0, ESCAPED, LOST)
        on = np.flatnonzero(away == 0)
        seeking, across = seeking.take(on), across.take(on, axis=1)
        if seeking.size:
            o[:, seeking] = across
            found = surface.query(across, d.take(seeking, axis=1))
            triangle[seeking] = found
            seeking = seeking[found < 0]
    triangle[seeking] = LOST
    return triangle


def _cross(surface: Surface, o: Array, d: Array) -> tuple[Array, Array]:
    """Origins where rays that met nothing enter the next period, and who has gone away before:
    +1 over the highest point, -1 under the lowest, 0 who has not.

    The mesh reaches a margin beyond the period, so the way to the period's rim, and a little of
    what follows, has been searched.
    """
    period = surface.period
    with np.errstate(divide="ignore", invalid="ignore"):
        to_rim = np.where(d[:2] > 0, period - o[:2], -o[:2]) / d[:2]
    to_rim[d[:2] == 0] = np.inf
    axis = np.argmin(to_rim, axis=0)
    lanes = np.arange(o.shape[1])
    distance = to_rim[axis, lanes]
    with np.errstate(invalid="ignore"):
        across = o + distance * d
    away = (across[2] >= surface.top).astype(np.int8) - (across[2] < surface.bottom)
    # A ray straight up or down never comes to the rim.
    vertical = np.isinf(distance)
    away[vertical] = np.sign(d[2, vertical])
    across[axis, lanes] = np.where(d[axis, lanes] > 0, 0, period)
    return across, away


def meet(surface: Surface, o: Array, d: Array, triangle: Array) -> tuple[Array, Array, Array]:
    """Where rays (3, n) meet the planes of their triangles (n,), in double precision.

    Returns points (3, n) within one period, whether the upper side is met (n,), and the slopes
    (2, n) of the planes, in the surface's coordinates.
    """
    offset, slope_u, slope_v = planes = surface.planes.take(triangle, axis=0).T
    approach = d[2] - slope_u * d[0] - slope_v * d[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (offset + slope_u * o[0] + slope_v * o[1] - o[2]) / approach
        point = o + distance * d
    # The rest of a division by floor costs a fifth of the modulo's.
    point[:2] -= surface.period * np.floor(point[:2] * (1 / surface.period))
    return point, approach < 0, planes[1:]
