"""Directions and facets where heights and slopes have variance 1, and distances to match.

A surface of roughness alpha_x, alpha_y is an isotropic one, stretched: x = (sqrt(2) / alpha_x) x',
and so is every formula of this folder.
"""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot

ROOT_HALF = float(np.sqrt(0.5))


@dataclass(frozen=True)
class Directions:
    """Directions of travel or of leaving as they climb, arrays (...) of one shape."""

    x: Array
    y: Array
    """Horizontal unit vector."""
    run: Array
    """Horizontal length of a unit of the way."""
    c: Array
    """Slope: standard deviations of height in a length."""

    def take(self, lanes: Array) -> "Directions":
        """Some of them."""
        return Directions(*(a.take(lanes) for a in vars(self).values()))

    def column(self) -> "Directions":
        """They as they broadcast against outgoing directions, (n, 1)."""
        return Directions(*(a[:, None] for a in vars(self).values()))


def directions(slopes: Slopes, d: Array) -> Directions:
    """Of unit vectors `d` (3, ...), in single precision; a vertical one has the x axis below it and
    a slope that is very large, but finite."""
    x, y = (d[i] * (alpha * ROOT_HALF) for i, alpha in enumerate(slopes.alpha))
    run = np.sqrt(x * x + y * y)
    least = np.finfo(d.dtype).eps ** 2
    x, run = np.where(run > least, x, least), np.maximum(run, least)
    parts = x / run, y / run, run, d[2] / run
    return Directions(*(a.astype(np.float32, copy=False) for a in parts))


def normals(slopes: Slopes, ray: Directions, along: Array, across: Array) -> Array:
    """Normals (3, n), not normalised, of facets of slopes `along` and `across` a ray (n,)."""
    m = np.empty((3, along.size), along.dtype)
    m[0] = (along * ray.x - across * ray.y) * (-slopes.alpha_x * ROOT_HALF)
    m[1] = (along * ray.y + across * ray.x) * (-slopes.alpha_y * ROOT_HALF)
    m[2] = 1
    return m


def clearance(ray: Directions, d: Array, m: Array) -> Array:
    """By how much the slope of rays along `d` is above that of facets of normals `m`, to all
    digits however little it is."""
    above: Array = (dot(d, m) / m[2] / ray.run).astype(np.float32, copy=False)
    return np.maximum(above, np.finfo(np.float32).eps)


def slopes_along(slopes: Slopes, ray: Directions, m: Array) -> tuple[Array, Array]:
    """Slopes along and across rays (...) of facets of normals `m` (3, ...), of any length."""
    x = m[0] / m[2] * (-1 / (slopes.alpha_x * ROOT_HALF))
    y = m[1] / m[2] * (-1 / (slopes.alpha_y * ROOT_HALF))
    return x * ray.x + y * ray.y, y * ray.x - x * ray.y


def turned(ray: Directions, bends: Array) -> Array:
    """A facet's curvatures along x, twice that of xy, and along y, from those along and across a
    ray, both (3, ...)."""
    along, mixed, across = bends
    x, y = ray.x, ray.y
    return np.stack(
        [
            along * x * x - mixed * x * y + across * y * y,
            2 * (along - across) * x * y + mixed * (x * x - y * y),
            along * y * y + mixed * x * y + across * x * x,
        ]
    )


def curvature(ray: Directions, bends: Array) -> Array:
    """Along rays (...), from those along the axes (3, ...)."""
    found: Array = bends[0] * ray.x * ray.x + bends[1] * ray.x * ray.y + bends[2] * ray.y * ray.y
    return found
