"""Heights and free paths as [HHdD16 impl.] Sections 1 and 3.1 print them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from msbsdf_cli.methods.published.areas import VERTICAL, library_erf
from msbsdf_cli.methods.published.visible_slopes import erfinv
from surfaces.facet import Array

LEVEL = 1e-4
"""Cosine below which a ray counts as level and keeps its height, whatever the surface."""

START = 0.999
"""Light starts 1 above the height below which so much of the surface lies."""


@dataclass(frozen=True)
class HeightDistribution:
    """C1 and its inverse, of arrays (n,)."""

    below: Callable[[Array], Array]
    inverse: Callable[[Array], Array]

    def start(self, dtype: type) -> Array:
        """The height at which walks start, (1,)."""
        return 1 + self.inverse(np.array([START], dtype))


def _clamp(x: Array, low: float, high: float) -> Array:
    """As C++ compares: what is no number becomes `high`, and nobody sees it."""
    x = np.where(x < high, x, high).astype(x.dtype)
    return np.where(x > low, x, low).astype(x.dtype)


def _gaussian_below(h: Array) -> Array:
    return 0.5 + 0.5 * library_erf(h / np.sqrt(h.dtype.type(2)))


def _gaussian_inverse(u: Array) -> Array:
    found: Array = np.sqrt(u.dtype.type(2)) * erfinv(2 * u - 1)
    return found


def _uniform_below(h: Array) -> Array:
    return _clamp(0.5 * (h + 1), 0, 1)


def _uniform_inverse(u: Array) -> Array:
    return _clamp(2 * u - 1, -1, 1)


HEIGHTS = {
    "uniform": HeightDistribution(_uniform_below, _uniform_inverse),
    "gaussian": HeightDistribution(_gaussian_below, _gaussian_inverse),
}


def escape(heights: HeightDistribution, Lambda: Array, cos: Array, h: Array) -> Array:
    """G_1 of a direction at a height: the probability of leaving that way unhindered."""
    with np.errstate(all="ignore"):
        value = heights.below(h) ** Lambda
    return np.where(cos > VERTICAL, 1, np.where(cos <= 0, 0, value))


def next_height(
    heights: HeightDistribution, Lambda: Array, cos: Array, h: Array, U: Array
) -> tuple[Array, Array]:
    """Who leaves the surface, and the height (n,) of the next facet of the others.

    Algorithm 1, and its three special cases: upward, downward, and level.
    """
    steep, level = np.abs(cos) > VERTICAL, np.abs(cos) < LEVEL
    leaves = (cos > VERTICAL) | (~steep & ~level & (1 - escape(heights, Lambda, cos, h) < U))
    with np.errstate(all="ignore"):
        slanted = heights.inverse(heights.below(h) / (1 - U) ** (1 / Lambda))
        straight = heights.inverse(U * heights.below(h))
    return leaves, np.where(level, h, np.where(steep, straight, slanted)).astype(h.dtype)
