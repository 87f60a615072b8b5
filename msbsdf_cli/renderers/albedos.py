"""Albedos of single scattering: what compensation for lost energy and samplers look up."""

from dataclasses import replace

import numpy as np

from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Conductor, Material
from surfaces.quadrature import hemisphere

ALPHAS, COSINES = 32, 32
"""Nodes of the table, at the middles of even parts of [0, 1]."""

POLAR, AZIMUTHAL = 8, 8
"""Directions that a mean over the hemisphere is taken of: right to .001, which is plenty for the
shares of a sampler."""


def nodes(count: int) -> Array:
    """Middles of even parts of [0, 1]: where textures have their values."""
    return (np.arange(count) + 0.5) / count


def albedos(slopes: Slopes) -> tuple[Array, Array]:
    """Directional albedo of mirrors by single scattering over alpha and cosine, (alphas, cosines),
    and its mean over the hemisphere, (alphas,): what energy compensation looks up."""
    cos = nodes(COSINES)
    wi = np.array([np.sqrt(1 - cos * cos), np.zeros_like(cos), cos])
    rows = []
    for alpha in nodes(ALPHAS).tolist():
        of = replace(slopes, alpha_x=alpha, alpha_y=alpha)
        rows.append(first_order_albedo(of, Conductor(), wi))
    directional = np.array(rows)
    return directional, (directional * 2 * cos).mean(axis=1)


def first_share(slopes: Slopes, material: Material) -> float:
    """The share of the light of constant surroundings, none absorbed, that leaves after its first
    facet; 0 for facets that are not specular, whose first order is no better sampled than later
    ones."""
    if not material.specular:
        return 0.0
    wi, solid_angle = hemisphere(POLAR, AZIMUTHAL)
    albedo = first_order_albedo(slopes, material, wi)
    return float((albedo * wi[2] * solid_angle).sum() / np.pi)
