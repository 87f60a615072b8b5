"""The textbook's formulas, written a second time: what the program's own are held against.

Nothing here uses the program's densities, projected areas, Lambda, masking or Fresnel functions;
Lambda comes from its definition as an integral over slopes, whose density a distribution brings
along for this purpose alone.
"""

from itertools import pairwise

import numpy as np
from scipy.special import beta

from msbsdf_cli.validation.configurations import IOR, Configuration
from surfaces.facet import Array
from surfaces.quadrature import gauss

NODES = 256
"""Gauss-Legendre nodes of the integral over slopes: twice as many change nothing above 1e-12."""

AREA_ERROR = 1e-10
"""Relative error of a projected area, from the nodes and rounding."""

DIFFUSE_NODES = 800
"""Midpoints over the slopes' polar angle, and half as many as over their azimuth."""

SEEN = 1e-12
"""Projected area below which a direction sees no facet but by its own rounding; [HHdD16 impl.]
4.3.3 warns of areas below .01."""


def projected_area(c: Configuration, w: Array) -> float:
    """Integral of <w, m> D(m) dm for one direction w (3, 1), [HHdD16] Eqs. 20 and 22.

    Along the stretched direction (s, z) of w the slope x has a density P2(x) of one variable, and
    the integral is that of (z - s x)+ P2(x). With x = tan(u) it is smooth up to its end, and no
    term is negative.
    """
    s = float(np.hypot(c.slopes.alpha[0] * w[0, 0], c.slopes.alpha[1] * w[1, 0]))
    z = float(w[2, 0])
    if s == 0:
        return max(z, 0.0)
    node, weight = gauss(NODES)
    end = np.arctan2(z, s)
    # Where the density is nothing to double precision there is no need of nodes.
    steepest = 30.0 if c.slopes.marginal_density(np.array(30.0)) == 0 else np.inf
    start = min(-np.arctan(steepest), end - 1e-3)
    parts = _split(start, end)
    total = 0.0
    for a, b in pairwise(parts):
        u = a + (b - a) * node
        # z - s tan(u), from its zero at u = end.
        lever = np.hypot(s, z) * np.sin(end - u) / np.cos(u)
        value = lever * c.slopes.marginal_density(np.tan(u)) / np.cos(u) ** 2
        total += float((value * weight).sum() * (b - a))
    return total


def _split(start: float, end: float) -> Array:
    """Borders between which the nodes are laid: where the Gaussian changes fastest."""
    inner = np.arctan([-6.0, -2.0, 0.0, 2.0, 6.0])
    return np.array([start, *inner[(inner > start) & (inner < end)], end])


def big_lambda(c: Configuration, w: Array) -> float:
    """Lambda(w) for a direction w (3, 1) above the surface: the area that faces away from it,
    over its cosine ([HHdD16] Eq. 21)."""
    return projected_area(c, -w) / float(w[2, 0])


def normal_density(c: Configuration, m: Array) -> Array:
    """D of unit vectors m (3, n): the slopes' density over cos^4."""
    x, y = -m[0] / m[2] / c.slopes.alpha[0], -m[1] / m[2] / c.slopes.alpha[1]
    slopes = c.slopes.slope_density(x, y)
    return np.where(m[2] > 0, slopes / (c.slopes.alpha[0] * c.slopes.alpha[1] * m[2] ** 4), 0)


def masking_shadowing(c: Configuration, wi: Array, wo: Array, correlated: bool = True) -> float:
    """G2 of directions (3, 1), wi above and wo on either side ([HHdD16] Appendix A); the product
    of both maskings where heights are uncorrelated ([WJFYHY22 supp.])."""
    Lambda_i = big_lambda(c, wi)
    Lambda_o = big_lambda(c, wo if wo[2, 0] > 0 else -wo)
    if not correlated:
        return 1 / ((1 + Lambda_i) * (1 + Lambda_o))
    if wo[2, 0] > 0:
        return 1 / (1 + Lambda_i + Lambda_o)
    return float(beta(1 + Lambda_i, 1 + Lambda_o))


def fresnel(cos_i: Array, eta: float) -> Array:
    """Reflectance of unpolarised light, eta behind over before, by g^2 = eta^2 - 1 + cos^2."""
    g2 = eta * eta - 1 + cos_i * cos_i
    g = np.sqrt(np.maximum(g2, 0))
    parallel = (cos_i * (g + cos_i) - 1) / (cos_i * (g - cos_i) + 1)
    value = ((g - cos_i) / (g + cos_i)) ** 2 * (1 + parallel**2) / 2
    return np.where(g2 > 0, value, 1.0)


def single_scattering(c: Configuration, wi: Array, wo: Array, correlated: bool = True) -> float:
    """BSDF x cos(theta_o) of the first bounce for directions (3, 1), [HHdD16] Eqs. 11 to 15:
    mirrors, and dielectrics on either side."""
    G2 = masking_shadowing(c, wi, wo, correlated)
    reflected = wo[2, 0] > 0
    if reflected:
        h = wi + wo
        eta_o = 1.0
    else:
        eta_o = IOR
        h = -(wi + eta_o * wo)
    length = float(np.sqrt((h * h).sum()))
    h = h / length
    cos_i, cos_o = float((wi * h).sum()), float((wo * h).sum())
    D = float(normal_density(c, h)[0])
    F = float(fresnel(np.array([cos_i]), IOR)[0]) if c.facets.transmits else 1.0
    if reflected:
        return F * D * G2 / (4 * float(wi[2, 0]))
    if cos_i <= 0 or cos_o >= 0:
        return 0.0
    # dh / dwo = eta_o^2 |wo . h| / (wi . h + eta_o wo . h)^2, with eta_i = 1.
    jacobian = eta_o**2 * abs(cos_o) / (cos_i + eta_o * cos_o) ** 2
    return (1 - F) * D * G2 * cos_i * jacobian / float(wi[2, 0])


def diffuse_scattering(c: Configuration, wi: Array, wo: Array, correlated: bool = True) -> float:
    """The same for diffuse facets of albedo 1 ([HHdD16] Eq. 17): <wi, m> <wo, m> D(m) / pi over
    the slopes, in polar coordinates, by midpoints, fine enough for the kinks."""
    psi = (np.arange(DIFFUSE_NODES) + 0.5) / DIFFUSE_NODES * np.pi / 2
    phi = (np.arange(2 * DIFFUSE_NODES) + 0.5) / DIFFUSE_NODES * np.pi
    r, phi = np.tan(psi)[:, None], phi[None]
    m = np.stack(
        [
            -c.slopes.alpha[0] * r * np.cos(phi),
            -c.slopes.alpha[1] * r * np.sin(phi),
            np.ones_like(r * phi),
        ]
    )
    P22 = c.slopes.slope_density(r, np.zeros_like(r))
    towards_i = np.maximum(np.einsum("i,ijk->jk", wi[:, 0], m), 0)
    towards_o = np.maximum(np.einsum("i,ijk->jk", wo[:, 0], m), 0)
    length = np.sqrt((m * m).sum(axis=0))
    # dm m_z = P22 dslopes; of the two cosines each has the length once, and m_z is 1 / length.
    value = towards_i * towards_o / length * P22 * r * (1 + r * r)
    integral = float(value.sum()) * (np.pi / 2 / DIFFUSE_NODES) * (np.pi / DIFFUSE_NODES)
    G2 = masking_shadowing(c, wi, wo, correlated)
    return integral / np.pi * G2 / float(wi[2, 0])
