"""Visible normals as [HHdD16 impl.] Section 2 samples them: by a search, or by a fit."""

import numpy as np

from msbsdf_cli.methods.published.areas import INV_2_SQRT_PI, library_erf
from msbsdf_cli.smith.slopes import Beckmann, Slopes
from surfaces.facet import Array

STEEP = 1e-4
"""Angle below which a direction counts as the zenith, and projected area below which the slope
is 0."""

ERF_LOW, ENOUGH = -0.9999, 1e-5
"""Where the search for Beckmann's slope begins on the axis of erf, and when it ends."""

FIT = ((0.27385, -0.73369, 0.46341, 0.0), (0.093073, 0.309420, -1.0, 0.597999))
"""Rational fit to the slope across of GGX, over sqrt(1 + slope_x^2) (Heitz & d'Eon 2014)."""

GILES_CENTRE = (
    *(2.81022636e-08, 3.43273939e-07, -3.5233877e-06, -4.39150654e-06, 0.00021858087),
    *(-0.00125372503, -0.00417768164, 0.246640727, 1.50140941),
)
GILES_TAIL = (
    *(-0.000200214257, 0.000100950558, 0.00134934322, -0.00367342844, 0.00573950773),
    *(-0.0076224613, 0.00943887047, 1.00167406, 2.83297682),
)
"""Single-precision fits to the inverse error function (Giles 2012), which implementations take
for the one that the supplemental does not print."""


def erfinv(x: Array) -> Array:
    """The inverse error function by Giles 2012, in the precision of `x`."""
    with np.errstate(all="ignore"):
        w = -np.log((1 - x) * (1 + x))
        centre, tail = _horner(GILES_CENTRE, w - 2.5), _horner(GILES_TAIL, np.sqrt(w) - 3)
        found: Array = np.where(w < 5, centre, tail) * x
    return found


def _horner(coefficients: tuple[float, ...], x: Array) -> Array:
    first, *others = (x.dtype.type(c) for c in coefficients)
    value = first * x
    for c in others[:-1]:
        value = (value + c) * x
    total: Array = value + others[-1]
    return total


def visible_normals(slopes: Slopes, wi: Array, rng: np.random.Generator) -> tuple[Array, int]:
    """Unit normals (3, ...) for directions `wi` (3, ...) anywhere on the sphere, and how many of
    them stand in for a slope that was not finite."""
    shape = wi.shape[1:]
    dtype = wi.dtype.type
    stretched = np.stack([slopes.alpha_x * wi[0], slopes.alpha_y * wi[1], wi[2]])
    stretched = stretched / np.sqrt((stretched * stretched).sum(axis=0))
    theta = np.arccos(stretched[2])
    U1: Array = np.asarray(rng.random(shape, dtype=dtype))
    U2: Array = np.asarray(rng.random(shape, dtype=dtype))
    gaussian = isinstance(slopes, Beckmann)
    x, y = beckmann_slopes(theta, U1, U2) if gaussian else ggx_slopes(theta, U1, U2)
    phi = np.arctan2(stretched[1], stretched[0])
    cos, sin = np.cos(phi), np.sin(phi)
    with np.errstate(invalid="ignore"):
        x, y = slopes.alpha_x * (cos * x - sin * y), slopes.alpha_y * (sin * x + cos * y)
    bad = ~np.isfinite(x)
    m = np.stack([-x, -y, np.ones_like(x)])
    if bad.any():
        up = wi[2] > 0
        level = np.stack([wi[0], wi[1], 0 * wi[2]])
        zenith = np.zeros_like(level)
        zenith[2] = 1
        m = np.where(bad, np.where(up, zenith, level), m)
    with np.errstate(all="ignore"):
        return m / np.sqrt((m * m).sum(axis=0)), int(bad.sum())


def _zenith_turned(radius: Array, U2: Array) -> tuple[Array, Array]:
    phi = 6.28318530718 * U2
    return radius * np.cos(phi), radius * np.sin(phi)


def ggx_slopes(theta: Array, U: Array, U2: Array) -> tuple[Array, Array]:
    """Visible slopes of GGX at roughness 1, (n,) each, for angles `theta` (n,) from 0 to pi."""
    a_fit, b_fit = FIT
    with np.errstate(all="ignore"):
        sin, cos = np.sin(theta), np.cos(theta)
        tan = sin / cos
        area = 0.5 * (cos + 1)
        A = 2 * U * area / cos - 1
        tmp = 1 / (A * A - 1)
        D = np.sqrt(np.maximum(tan * tan * tmp * tmp - (A * A - tan * tan) * tmp, 0))
        low, high = tan * tmp - D, tan * tmp + D
        x = np.where((A < 0) | (high > 1 / tan), low, high)
        sign = np.where(U2 > 0.5, 1, -1).astype(U2.dtype)
        v = np.where(U2 > 0.5, 2 * (U2 - 0.5), 2 * (0.5 - U2))
        z = _horner(a_fit, v) / _horner(b_fit, v)
        y = sign * z * np.sqrt(1 + x * x)
        x0, y0 = _zenith_turned(np.sqrt(U / (1 - U)), U2)
    unseen = (area < STEEP) | np.isnan(area)
    zenith = theta < STEEP
    x = np.where(zenith, x0, np.where(unseen, 0, x)).astype(theta.dtype)
    y = np.where(zenith, y0, np.where(unseen, 0, y)).astype(theta.dtype)
    return x, y


def beckmann_slopes(theta: Array, U: Array, U2: Array) -> tuple[Array, Array]:
    """Visible slopes of Beckmann at roughness 1, likewise: a Newton iteration kept in a bracket."""
    dtype = theta.dtype
    with np.errstate(all="ignore"):
        sin, cos = np.sin(theta), np.cos(theta)
        a = cos / sin
        area = 0.5 * (library_erf(a) + 1) * cos + INV_2_SQRT_PI * sin * np.exp(-a * a)
        x0, y0 = _zenith_turned(np.sqrt(-np.log(U)), U2)
        unseen = (area < STEEP) | np.isnan(area)
        zenith = theta < STEEP
        x = np.zeros_like(theta)
        lanes = ~(unseen | zenith)
        x[lanes] = _search(sin[lanes], cos[lanes], area[lanes], U[lanes])
        y = erfinv(2 * U2 - 1)
    x = np.where(zenith, x0, x).astype(dtype)
    y = np.where(zenith, y0, np.where(unseen, 0, y)).astype(dtype)
    return x, y


def _search(sin: Array, cos: Array, area: Array, U: Array) -> Array:
    """Slopes whose distribution function is U, on the axis of erf from ERF_LOW on."""
    steepest, c = cos / sin, 1 / area
    low = np.full_like(U, ERF_LOW)
    high = np.maximum(low, library_erf(steepest))
    at = 0.5 * (low + high)
    searching = np.flatnonzero(high - low > ENOUGH)
    while searching.size:
        i = searching
        inside = (at[i] >= low[i]) & (at[i] <= high[i])
        at[i] = np.where(inside, at[i], 0.5 * (low[i] + high[i]))
        slope = erfinv(at[i])
        exponential = INV_2_SQRT_PI * sin[i] * np.exp(-slope * slope)
        cdf = c[i] * (exponential + cos[i] * (0.5 + 0.5 * library_erf(slope)))
        diff = np.where(slope >= steepest[i], 1, cdf) - U[i]
        above = diff > 0
        done = (np.abs(diff) < ENOUGH) | (np.where(above, high[i], low[i]) == at[i])
        high[i] = np.where(above & ~done, at[i], high[i])
        low[i] = np.where(~above & ~done, at[i], low[i])
        step = diff / (0.5 * c[i] * (cos[i] - sin[i] * slope))
        at[i] = np.where(done, at[i], at[i] - step)
        searching = i[~done & (high[i] - low[i] > ENOUGH)]
    return erfinv(np.minimum(high, np.maximum(low, at)))
