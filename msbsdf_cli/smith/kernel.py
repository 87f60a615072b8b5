"""How the facets of a Smith microsurface scatter light from one direction of travel to another.

q(d -> w) = integral of <-d, m> D(m) f(d, m, w) dm, per steradian of `w`, f being the energy that a
facet sends into w (its BSDF times |w . m|). Over all `w` it sums to sigma(d), less what is
absorbed, so that q(d -> w) / sigma(d) is the phase function of [HHdD16] (Section 6); but q needs no
division by an area that vanishes, and for a mirror it is the same seen from both ends.

Inside a dielectric everything is point-reflected, as in `msbsdf_cli.smith.walk`: a direction is
given in the frame of the side it travels in, where light that heads away from the surface
has z > 0. Arrays of directions are (3, ...), and broadcast against each other.
"""

import numpy as np
from scipy.special import betaln

from msbsdf_cli.smith.lune import lambertian_density
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, dot, fresnel_dielectric
from surfaces.materials import Conductor, Dielectric, Diffuse, Material

QUADRATURE_BLOCK = 64
"""Directions integrated over at once: a few thousand slopes for each of them."""


def scatter_density(
    slopes: Slopes,
    material: Material,
    d: Array,
    w: Array,
    inside: bool = False,
    transmitted: bool = False,
) -> Array:
    """q(d -> w) per steradian, (channels, n), for directions of travel (3, n) or (3, 1).

    Without noise: diffuse facets are integrated over by quadrature ([HHdD16] Eq. 17).
    """
    if isinstance(material, Diffuse):
        density = diffuse_density(slopes, d, w)
        return np.array(material.albedos, density.dtype)[:, None] * density
    if transmitted:
        return refraction_density(slopes, material, d, w, inside)[None]
    density, colour = reflection_density(slopes, material, d, w, inside)
    return density[None] if colour is None else density * colour


def reflection_density(
    slopes: Slopes, material: Material, d: Array, w: Array, inside: bool = False
) -> tuple[Array, Array | None]:
    """q of specular facets that reflect, (...), and a metal's reflectance (channels, ...).

    F D(h) / 4, h being the half vector of -d and w; no facet points below the horizon.
    """
    h = w - d
    length = np.sqrt(dot(h, h))
    density = _density_of_normals(slopes, h, length) / 4
    cos_i = length / 2
    if isinstance(material, Dielectric):
        return density * fresnel_dielectric(cos_i, relative_ior(material, inside))[0], None
    if isinstance(material, Conductor) and material.absorbs:
        colour = material.fresnel(cos_i.ravel())
        return density, colour.reshape(material.channels, *cos_i.shape)
    return density, None


def refraction_density(
    slopes: Slopes, material: Material, d: Array, w: Array, inside: bool = False
) -> Array:
    """q of facets that refract, (...): `d` on the side of arrival, `w` point-reflected beyond.

    In that frame the normal of [HHdD16] Eq. 35, -(i + eta o), is d + eta w, or its opposite
    where the medium beyond is the thinner; its length is |eta_i (i . h) + eta_o (o . h)|.
    """
    assert isinstance(material, Dielectric)
    eta = relative_ior(material, inside)
    h = (eta * w + d) * (1 if eta > 1 else -1)
    length = np.sqrt(dot(h, h))
    m = h / np.maximum(length, np.finfo(h.dtype).tiny)
    cos_i, cos_t = -dot(d, m), dot(w, m)
    faces = (cos_i > 0) & (cos_t > 0)
    fresnel = fresnel_dielectric(np.clip(cos_i, 0, 1), eta)[0]
    jacobian = eta * eta * cos_i * cos_t / (length * length)
    return np.where(faces, (1 - fresnel) * jacobian * _density_of_normals(slopes, h, length), 0)


def diffuse_density(slopes: Slopes, d: Array, w: Array) -> Array:
    """q of diffuse facets of albedo 1, (n,), by quadrature over the slopes that face both ways."""
    n = max(d.shape[1], w.shape[1])
    d, w = np.broadcast_to(d, (3, n)), np.broadcast_to(w, (3, n))
    density = np.empty(n, w.dtype)
    for start in range(0, n, QUADRATURE_BLOCK):
        block = slice(start, start + QUADRATURE_BLOCK)
        density[block] = lambertian_density(slopes, d[:, block], w[:, block])
    return density


def relative_ior(material: Dielectric, inside: bool) -> float:
    """Index behind the facet over the index before it."""
    return 1 / material.ior if inside else material.ior


def masking_shadowing(
    slopes: Slopes, wi: Array, wo: Array, transmitted: bool, correlated: bool = True
) -> Array:
    """G2 / cos(theta_i), (n,), for `wi` and `wo` above the surface (`wo` point-reflected if
    transmitted): with q it makes the first order, f cos(theta_o) = q G2 / cos(theta_i).

    Correlated heights: 1 / (1 + Lambda_i + Lambda_o) or the Beta function of [HHdD16 impl.] 3.4,
    by logarithms of the gamma function, which do not overflow. Otherwise the product of
    1 / (1 + Lambda) of either direction.
    """
    sigma_i, cos_o = slopes.sigma(-wi), wo[2]
    if transmitted and correlated:
        # B(L_i, 1 + Lambda_o) with L_i = 1 + Lambda_i.
        L_i, Lambda_o = np.asarray(sigma_i / wi[2], float), np.asarray(slopes.sigma(wo) / cos_o)
        return (np.exp(betaln(L_i, 1 + Lambda_o)) / wi[2]).astype(wo.dtype)
    if correlated:
        return cos_o / (sigma_i * cos_o + slopes.sigma(wo) * wi[2])
    return cos_o / (sigma_i * slopes.sigma(-wo))


def _density_of_normals(slopes: Slopes, h: Array, length: Array) -> Array:
    """D of half vectors (3, ...) of the given length, 0 for those below the horizon.

    So near to the horizon that cos^4 of their angle underflows, they count as below.
    """
    horizon = np.finfo(h.dtype).tiny ** 0.25
    above = h[2] > horizon * length
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(above, slopes.D(h / length), 0)
