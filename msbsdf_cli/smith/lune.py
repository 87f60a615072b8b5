"""Diffuse facets: the integral over those that see both directions, by quadrature over a lune."""

import numpy as np

from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot

LUNE_NODES = 40
"""Gauss nodes along each side of the lune of facets that see both directions. The integrand is
smooth there; 40 leave an error of some 1e-6 of the largest value."""


def lambertian_density(slopes: Slopes, d: Array, w: Array) -> Array:
    """1/pi of the integral of <-d, m> <w, m> D(m) dm ([HHdD16] Eq. 36, times sigma).

    Facets that see both directions fill a lune between two great circles. Stretched by the
    roughness, m = A m' / |A m'|, a lune stays a lune and D's width leaves the integrand. Half
    circles from pole to pole, at angles eta, are cut by the horizon at chi = `cut`.
    """
    stretch = np.array([slopes.alpha_x, slopes.alpha_y, 1.0])[:, None]
    a, b = -d * stretch, w * stretch
    axis, e1, e2 = _lune_frame(a, b)
    u, du = np.polynomial.legendre.leggauss(LUNE_NODES)
    u, du = (u + 1) / 2, du / 2
    eta, d_eta = _half_circles(np.arctan2(dot(b, e2), dot(b, e1)), e1, e2, u, du)
    equator = np.cos(eta) * e1[:, None] + np.sin(eta) * e2[:, None]
    # What is above the horizon starts at one pole or, if that is the lower one, ends at the other.
    # By comparison and not by the sign of a zero, or a level axis would lose all of its lune.
    downward = axis[2] < 0
    cut = np.arctan2(np.abs(axis[2]), np.where(downward, 1, -1) * equator[2])
    low, high = np.where(downward, cut, 0), np.where(downward, np.pi, cut)
    chi = low + u[:, None, None] * (high - low)
    m = np.cos(chi) * axis[:, None, None] + np.sin(chi) * equator[:, None]
    lit = np.maximum(dot(m, a[:, None, None]), 0) * np.maximum(dot(m, b[:, None, None]), 0)
    m = m * stretch[:, None, None]
    length = np.sqrt(dot(m, m))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        density = slopes.D(m / length) * lit * np.sin(chi) / length**5
    total: Array = np.einsum("ken,k,en,en->n", density, du, d_eta, high - low)
    return total * (slopes.alpha_x * slopes.alpha_y / np.pi)


def _half_circles(phi_b: Array, e1: Array, e2: Array, u: Array, du: Array) -> tuple[Array, Array]:
    """Angles eta and weights across the lune, which is as wide as `b` is near to `a` = e1.

    The cut moves from pole to pole where a half circle passes the horizon, all the faster the
    flatter the lune's axis lies, and at once where it is horizontal: nodes are clustered there.
    """
    start, stop = phi_b - np.pi / 2, np.full_like(phi_b, np.pi / 2)
    crossing = start + np.mod(np.arctan2(-e1[2], e2[2]) - start, np.pi)
    crossing = np.minimum(crossing, stop)
    power, slope = u[:, None] ** 3, 3 * (u * u * du)[:, None]
    eta = [crossing + power * (end - crossing) for end in (start, stop)]
    weight = [slope * np.abs(end - crossing) for end in (start, stop)]
    return np.concatenate(eta), np.concatenate(weight)


def _lune_frame(a: Array, b: Array) -> tuple[Array, Array, Array]:
    """The axis a x b and two directions normal to it, the first along `a`."""
    e1 = a / np.sqrt(dot(a, a))
    axis = np.cross(a, b, axis=0)
    length = np.sqrt(dot(axis, axis))
    # Parallel directions see the same facets: any axis normal to them will do.
    x, _, z = np.eye(3)[:, :, None]
    fallback = np.cross(e1, np.where(np.abs(e1[2]) < np.abs(e1[0]), z, x), axis=0)
    axis = np.where(length > 0, axis, fallback)
    axis /= np.sqrt(dot(axis, axis))
    return axis, e1, np.cross(axis, e1, axis=0)
