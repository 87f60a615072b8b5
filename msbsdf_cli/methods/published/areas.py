"""Distributions of normals and projected areas as [HHdD16 impl.] Section 2 prints them.

Every direction within VERTICAL of the zenith counts as vertical, and all else goes through an
angle: its arc cosine, and the tangent of that.
"""

import numpy as np
from scipy.special import erf

from msbsdf_cli.smith.slopes import Beckmann, Slopes
from surfaces.facet import Array, dot

VERTICAL = 0.9999
"""Cosine above which Lambda is 0 and the projected area 1, or below the negative of which -1 and
0 ([HHdD16 impl.], `Lambda` and `projectedArea`)."""

INV_2_SQRT_PI = 0.5 / np.sqrt(np.pi)


def polynomial_erf(x: Array) -> Array:
    """The error function by Abramowitz & Stegun 7.1.26, which some implementations take: right to
    1.5e-7, of which nothing is left of a Lambda that is small itself."""
    t = 1 / (1 + 0.3275911 * np.abs(x))
    poly = ((((1.061405429 * t - 1.453152027) * t) + 1.421413741) * t - 0.284496736) * t
    found: Array = np.sign(x) * (1 - (poly + 0.254829592) * t * np.exp(-x * x))
    return found


def library_erf(x: Array) -> Array:
    """That of the language's library: in double precision, whatever comes in."""
    return np.asarray(erf(np.asarray(x, float)), x.dtype)


def projected_roughness(slopes: Slopes, w: Array) -> Array:
    """alpha_i of directions (3, ...): by a division that the zenith does not survive."""
    inverse = 1 / (1 - w[2] * w[2])
    cos2, sin2 = w[0] * w[0] * inverse, w[1] * w[1] * inverse
    return np.sqrt(cos2 * slopes.alpha_x**2 + sin2 * slopes.alpha_y**2)


def Lambda(slopes: Slopes, w: Array, polynomial: bool = False) -> Array:
    """Smith's function over the sphere, of directions (3, ...)."""
    with np.errstate(all="ignore"):
        a = 1 / np.tan(np.arccos(w[2])) / projected_roughness(slopes, w)
        if isinstance(slopes, Beckmann):
            error_function = polynomial_erf if polynomial else library_erf
            value = 0.5 * (error_function(a) - 1) + INV_2_SQRT_PI / a * np.exp(-a * a)
        else:
            value = 0.5 * (-1 + np.sign(a) * np.sqrt(1 + 1 / (a * a)))
    value = np.where(w[2] > VERTICAL, 0, value)
    return np.where(w[2] < -VERTICAL, -1, value).astype(w.dtype)


def projected_area(slopes: Slopes, w: Array) -> Array:
    """Area of the facets that face `w` (3, ...), projected on the plane normal to it."""
    with np.errstate(all="ignore"):
        alpha, theta = projected_roughness(slopes, w), np.arccos(w[2])
        sin = np.sin(theta)
        if isinstance(slopes, Beckmann):
            a = 1 / np.tan(theta) / alpha
            value = 0.5 * (library_erf(a) + 1) * w[2]
            value = value + INV_2_SQRT_PI * alpha * sin * np.exp(-a * a)
        else:
            value = 0.5 * (w[2] + np.sqrt(w[2] * w[2] + sin * sin * alpha * alpha))
    value = np.where(w[2] > VERTICAL, 1, value)
    return np.where(w[2] < -VERTICAL, 0, value).astype(w.dtype)


def normals(slopes: Slopes, m: Array) -> Array:
    """D of unit vectors (3, ...): slopes over the fourth power of a cosine."""
    with np.errstate(all="ignore"):
        x, y = -m[0] / m[2], -m[1] / m[2]
        exponent = x * x / slopes.alpha_x**2 + y * y / slopes.alpha_y**2
        density = np.exp(-exponent) if isinstance(slopes, Beckmann) else 1 / (1 + exponent) ** 2
        value = density / (np.pi * slopes.alpha_x * slopes.alpha_y) / (m[2] * m[2] * m[2] * m[2])
    return np.where(m[2] <= 0, 0, value).astype(m.dtype)


def visible(slopes: Slopes, wi: Array, m: Array, area: Array | None = None) -> Array:
    """D_wi(m), the distribution of normals visible from `wi`; `area` is the projected one."""
    area = projected_area(slopes, wi) if area is None else area
    with np.errstate(all="ignore"):
        value = 1 / area * np.maximum(dot(wi, m), 0) * normals(slopes, m)
    return np.where((m[2] <= 0) | (area == 0), 0, value)
