"""The share of light that leaves a microsurface after its first facet, by quadrature."""

import numpy as np

from msbsdf_cli.smith.masking import masking_shadowing
from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.visible_slopes import visible_slopes
from surfaces.facet import Array, dot, fresnel_dielectric
from surfaces.materials import Material
from surfaces.quadrature import hemisphere

DIRECTIONS_BLOCK = 4
"""Directions integrated over at once, with a few thousand slopes for each: arrays that stay in a
core's cache."""

RADIAL_NODES = 28
AZIMUTH_NODES = 36
"""With these, albedos are right to 1e-5 down to the horizon, and to 1e-2 where total internal
reflection begins along a line that no node knows of."""

DIFFUSE_NODES = 12
"""Polar and half the azimuthal directions that a diffuse albedo is summed over."""


def first_order_albedo(
    slopes: Slopes, material: Material, wi: Array, inside: bool = False
) -> Array:
    """Energy (n,) of the first order, both sides together, for `wi` (3, n) above the surface.

    Metals count as perfect mirrors and diffuse facets as white: 1 less this is what only later
    bounces can return. `inside`: for light that arrives from within, `wi` point-reflected.
    """
    n = wi.shape[1]
    if not material.specular:
        return np.array([_of_lobes(slopes, material.lossless, wi[:, [k]]) for k in range(n)])
    albedo = np.empty(n)
    for start in range(0, n, DIRECTIONS_BLOCK):
        block = slice(start, start + DIRECTIONS_BLOCK)
        albedo[block] = _specular(slopes, material, wi[:, block].astype(float), inside)
    return albedo


def _specular(slopes: Slopes, material: Material, wi: Array, inside: bool) -> Array:
    # Of one roughness, either side of the plane of incidence mirrors the other.
    half = slopes.isotropic
    m, weight = visible_slopes(slopes, -wi, RADIAL_NODES, AZIMUTH_NODES, split=True, half=half)
    sigma_i = slopes.sigma(-wi)
    w_i = np.broadcast_to(wi[:, None, :], m.shape)
    cos_i = dot(w_i, m)
    up = 2 * cos_i * m - w_i
    if not material.transmits:
        return (weight * _passes(slopes, wi, sigma_i, up, False)).sum(axis=0)
    eta = material.relative_ior(inside)
    fresnel, cos_t = fresnel_dielectric(cos_i, eta)
    # The refracted direction, point-reflected: it leaves where its z is positive.
    through = w_i / eta - (cos_i / eta - cos_t) * m
    reflected = fresnel * _passes(slopes, wi, sigma_i, up, False)
    transmitted = (1 - fresnel) * _passes(slopes, wi, sigma_i, through, True)
    return (weight * (reflected + transmitted)).sum(axis=0)


def _passes(slopes: Slopes, wi: Array, sigma_i: Array, w: Array, transmitted: bool) -> Array:
    """G2 / cos(theta_i) (nodes, n), 0 for directions that head for the surface again."""
    shape, w = w.shape[1:], w.reshape(3, -1)
    up = np.flatnonzero(w[2] > 0)
    which = up % shape[1]
    wi, sigma_i = wi.take(which, axis=1), sigma_i.take(which)
    passes = np.zeros(w.shape[1])
    passes[up] = masking_shadowing(slopes, wi, w.take(up, axis=1), transmitted, True, sigma_i)
    return passes.reshape(shape)


def _of_lobes(slopes: Slopes, material: Material, wi: Array) -> float:
    """By a product rule over outgoing directions, finer towards the horizon."""
    w, solid_angle = hemisphere(DIFFUSE_NODES, 2 * DIFFUSE_NODES, power=2)
    value = material.density(slopes, -wi, w)[0] * masking_shadowing(slopes, wi, w, False)
    return float((value * solid_angle).sum())
