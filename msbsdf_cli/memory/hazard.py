"""The rate at which a ray meets the surface, given the facet that it left.

Rice's formula for crossings (S. O. Rice, Bell System Technical Journal 24, 1945), over the
probability that the surface is below the ray, all given the facet:

    nu / P(h(x) < l),   nu = p(h(x) = l) E[(h'(x) - c)+ | h(x) = l]

Without the facet it is Smith's, whose integral is closed. It would be the ray's true hazard if that
the ray is free up to x were no more than that the surface is below it at x. It is looked back once,
to the distance x - tau behind: the hazard is that times

    P(h(x - tau) < l(x - tau) | a crossing at x) / P(h(x - tau) < l(x - tau) | h(x) < l)

both by the means and variances of the height behind. What goes down through the ray comes up
through it elsewhere, -d ln P(h(x) < l) / dx = (nu - nu_down) / P(h(x) < l): so the integral of the
hazard is a difference of logarithms, which no step is too long for, and that of the downward
crossings."""

from typing import NamedTuple

import numpy as np

from msbsdf_cli.memory import normal
from msbsdf_cli.memory.correlation import Correlation
from surfaces.facet import Array


class Parts(NamedTuple):
    """What the hazard is made of, (n,)."""

    below: Array
    """ln P(h < l)."""
    down: Array
    """Downward crossings over P per length."""
    factor: Array
    """Of looking back."""
    b: Array
    """Of the ray above the surface, in standard deviations."""
    at_b: Array
    at_k: Array
    """Nodes of that, and of what the ray's slope is above the surface's."""


def near(correlation: Correlation, place: Array, facet: Array) -> Parts:
    """The parts of the hazard at the lattice's places (n,), given the four numbers of the facet,
    (4, n)."""
    rows = correlation.distances
    b, k, back = (linear(block, place, facet) for block in rows)
    height, slope, rate = correlation.behind.take(place, axis=1)
    return _parts(b, k, back, height, slope, rate)


def linear(rows: Array, place: Array, numbers: Array) -> Array:
    """The sum (n,) of `rows` (k, m) at the lattice's places (n,) times `numbers` (k, n)."""
    total: Array = rows[0].take(place) * numbers[0]
    for row, number in zip(rows[1:], numbers[1:], strict=True):
        total += row.take(place) * number
    return total


def far(correlation: Correlation, level: Array, c: Array) -> Parts:
    """The same where nothing is remembered of the facet, at heights `level` of rays of slope
    `c`."""
    back = level - c * level.dtype.type(correlation.lag)
    return _parts(level, c, back, *correlation.far)


def _parts(b: Array, k: Array, back: Array, height: Array, slope: Array, rate: Array) -> Parts:
    """From the standardised distances, the correlations of the height behind with the height and,
    given that, with the slope, and the rate of crossings."""
    at_b, at_k = normal.node(b), normal.node(k)
    M = normal.TRUNCATED.take(at_b)
    rest = 1 - height * height
    crossing = back - height * b - slope * normal.CROSSING.take(at_k)
    crossing = crossing / np.sqrt(rest - slope * slope * (1 - normal.SCATTER.take(at_k)))
    free = (back + height * M) / np.sqrt(1 - height * height * normal.NARROWER.take(at_b))
    factor = np.exp(
        normal.LOG_BELOW.take(normal.node(crossing)) - normal.LOG_BELOW.take(normal.node(free))
    )
    down = rate * M * normal.LESS.take(at_k)
    return Parts(normal.LOG_BELOW.take(at_b), down, factor, b, at_b, at_k)
