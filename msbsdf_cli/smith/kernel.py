"""The scattering kernel q(d -> w): what a microsurface scatters from one direction into another,
projected on the direction it arrives in, and written without a denominator.

With p the phase function of a facet and sigma the projected area, q(d -> w) = sigma(d) p(-d, w)
([HHdD16] Eqs. 22 and 33). Reciprocity is plain to see: q(d -> w) = q(-w -> -d) (Eq. 38).
"""

import numpy as np

from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot, fresnel_dielectric
from surfaces.materials import Conductor, Diffuse

LUNE_NODES = 40
"""Gauss nodes along each side of the lune of facets that see both directions. The integrand is
smooth there; 40 leave an error of some 1e-6 of the largest value."""

PAIRS = 64
"""Pairs of directions for which lunes are added up together."""


def scatter_density(slopes: Slopes, material: Conductor | Diffuse, d: Array, w: Array) -> Array:
    """Projected scattering q(d -> w), (channels, n), per steradian of `w`.

    `d` and `w` are unit directions of travel (3, n) anywhere on the sphere, `d` before the facet
    and `w` after it, one for each. Over all `w` q integrates to sigma(d), times the facet's
    albedo.
    """
    if isinstance(material, Conductor):
        return _mirror(slopes, material, d, w)
    q = np.empty(w.shape[1])
    for i in range(0, q.size, PAIRS):
        part = slice(i, i + PAIRS)
        q[part] = _lambertian(slopes, d[:, part], w[:, part])
    channels: Array = np.multiply.outer(np.array(material.albedo), q)
    return channels


def _mirror(slopes: Slopes, material: Conductor, d: Array, w: Array) -> Array:
    """F D(h) / 4 about the half vector h ([HHdD16] Eq. 35, times sigma)."""
    h = w - d
    length = np.sqrt(dot(h, h))
    with np.errstate(divide="ignore", invalid="ignore"):
        h /= length
        density = slopes.D(h) / 4
    # Straight on, h = 0: no facet does that.
    density = np.where(length > 0, density, 0)[None]
    return density * material.fresnel(length / 2) if material.absorbs else density


def _lambertian(slopes: Slopes, d: Array, w: Array) -> Array:
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
    cut = np.arctan2(np.abs(axis[2]), -np.copysign(1, axis[2]) * equator[2])
    low, high = np.where(axis[2] < 0, cut, 0), np.where(axis[2] < 0, np.pi, cut)
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


def dielectric_density(slopes: Slopes, eta: float, d: Array, w: Array) -> tuple[Array, Array]:
    """Projected scattering (n,) off and through a dielectric interface, per steradian of `w`.

    `eta` is the index behind the facets over the index before them. `w` (3, n) after
    transmission is point-reflected, as seen by one who stands on the other side with the surface
    below ([HHdD16] Fig. 11). Both terms are those of [HHdD16] Eq. 34, times sigma, with m along
    d + eta w. Reversed: q_T(d -> w) = eta^2 q_T'(-w -> -d), where the
    dash is for the other side.
    """
    mirror = _mirror(slopes, Conductor(), d, w)[0]
    h = w - d
    reflected = mirror * fresnel_dielectric(np.sqrt(dot(h, h)) / 2, eta)[0]
    m = (d + eta * w) * np.sign(eta - 1)
    length2 = dot(m, m)
    m = m / np.sqrt(length2)
    cos_i, cos_t = np.maximum(-dot(d, m), 0), np.maximum(dot(w, m), 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Where only rounding says that the facet is seen, total reflection hides it.
        kept = 1 - fresnel_dielectric(cos_i, eta)[0]
        transmitted = kept * cos_i * cos_t * slopes.D(m) * eta * eta / length2
    return reflected, np.where((cos_i > 0) & (cos_t > 0) & (m[2] > 0), transmitted, 0)
