"""The integral over the facets that are visible from both of two directions, by quadrature."""

import numpy as np

from surfaces.facet import Array, dot
from surfaces.materials._material import Normals
from surfaces.quadrature import gauss

ACROSS = 40
ALONG = 28
"""Gauss nodes across the lune of facets that see both directions, on either side of where its half
circles pass the horizon, and along each of them. The integrand is smooth there; so many leave an
error of a few 1e-6 of the largest value, and 1e-4 at roughness 30."""


BLOCK = 16
"""Directions taken together: their nodes stay in the cache."""


def lambertian_density(normals: Normals, d: Array, w: Array) -> Array:
    """1/pi of the integral of <-d, m> <w, m> D(m) dm ([HHdD16] Eq. 36, times sigma).

    Facets that see both directions fill a lune between two great circles. Stretched by the
    roughness, m = A m' / |A m'|, a lune stays a lune, D is D(A m') |A m'|^4, whose width is that of
    roughness 1, and dm is dm' times alpha_x alpha_y / |A m'|^3. Half circles from pole to pole, at
    angles eta, are cut by the horizon at chi = `cut`; along them both cosines go with sin(chi).
    """
    found = np.empty(max(d.shape[1], w.shape[1]), np.result_type(d, w))
    for start in range(0, found.size, BLOCK):
        block = slice(start, start + BLOCK)
        ends = (a if a.shape[1] == 1 else a[:, block] for a in (d, w))
        found[block] = _density(normals, *ends)
    return found


def _density(normals: Normals, d: Array, w: Array) -> Array:
    stretch = np.array([normals.alpha_x, normals.alpha_y, 1.0])[:, None]
    a, b = -d * stretch, w * stretch
    axis, e1, e2 = _lune_frame(a, b)
    phi_b = np.arctan2(dot(b, e2), dot(b, e1))
    eta, d_eta = _half_circles(phi_b, e1, e2, *gauss(ACROSS))
    cos, sin = np.cos(eta), np.sin(eta)
    equator = cos * e1[:, None] + sin * e2[:, None]
    lit = np.maximum(dot(a, e1) * cos, 0) * np.maximum(dot(b, e1) * cos + dot(b, e2) * sin, 0)
    # What is above the horizon starts at one pole or, if that is the lower one, ends at the other.
    # By comparison and not by the sign of a zero, or a level axis would lose all of its lune.
    downward = axis[2] < 0
    cut = np.arctan2(np.abs(axis[2]), np.where(downward, 1, -1) * equator[2])
    low = np.where(downward, cut, 0)
    extent = np.where(downward, np.pi, cut) - low
    u, du = gauss(ALONG)
    chi = low + u[:, None, None] * extent
    cos, sin = np.cos(chi), np.sin(chi)
    m = np.empty((3, *chi.shape), chi.dtype)
    for i in range(3):
        m[i] = stretch[i] * (cos * axis[i] + sin * equator[i])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        density = normals.D(m) * (sin * sin * sin) / np.sqrt(dot(m, m))
    total: Array = np.einsum("ken,k,en->n", density, du, d_eta * extent * lit)
    return total * (normals.alpha_x * normals.alpha_y / np.pi)


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
