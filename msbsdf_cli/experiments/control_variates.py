"""Control variates of light on an explicit surface: what its facets tell without tracing.

They are means over facets, weighted by the area that the incident light would see of each if none
shadowed another: of 1, of whether a mirror there sends the light upwards, and of the cosine that it
then has to the normal. Most of what one surface has more than another of the light of the first
order, and of what is left for the later ones, is due to them. Their expected values are integrals
over the slope distribution: those of a Gaussian field, so that what a finite number of waves does
to the slopes of all surfaces alike is taken off as well.
"""

from dataclasses import replace

import numpy as np

from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.visible_slopes import visible_slopes
from surfaces.facet import Array
from surfaces.marginal import GAUSSIAN_HEIGHTS, Marginal
from surfaces.surface import Surface
from surfaces.views import Views

NUMBER = 3

PER_LENGTH = 8
"""Facets a correlation length, along each axis, that are looked at: what lies between is like
them."""


def controls(surface: Surface, views: Views, wi: Array) -> Array:
    """The controls (3,) of all views of a surface, for light from the unit vector `wi` (3,)."""
    slopes = surface.slopes(max(surface.cells // PER_LENGTH, 1))
    # Normals of z = 1: their areas are linear in the slopes, and their lengths are the same after
    # half a turn, and upside down.
    area = np.maximum(wi[2] + (wi[:2] @ views.slopes) @ slopes, 0)
    quarter = views.slopes[:2] @ slopes
    squares = np.tile(1 + (quarter * quarter).sum(axis=1), (len(area) // 2, 1))
    return np.array([part.mean() for part in _parts(area, 2 * area / squares - wi[2])])


def expected(slopes: Slopes, wi: Array, marginal: Marginal = GAUSSIAN_HEIGHTS) -> Array:
    """Their expected values (3,), on heights of any marginal: where these have one value, slopes
    are Beckmann's, of a roughness in proportion to `slopes`."""
    total = np.zeros(NUMBER)
    for scale, share in marginal.roughness():
        alpha_x, alpha_y = (scale * a for a in slopes.alpha)
        rougher = replace(slopes, alpha_x=alpha_x, alpha_y=alpha_y)
        m, area = (a[..., 0] for a in visible_slopes(rougher, -wi[:, None], split=True))
        total += [share * p.sum() for p in _parts(area, 2 * (wi @ m) * m[2] - wi[2])]
    return total


def _parts(area: Array, cos_o: Array) -> tuple[Array, Array, Array]:
    """From visible areas and the cosines of mirrored light."""
    return area, area * (cos_o > 0), area * np.maximum(cos_o, 0)
