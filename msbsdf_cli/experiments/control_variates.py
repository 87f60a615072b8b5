"""Control variates of light on an explicit surface: what its facets tell without tracing.

They are means over facets, weighted by the area that the incident light would see of each if none
shadowed another: of 1, of whether a mirror there sends the light upwards, and of the cosine that it
then has to the normal. Most of what one surface has more than another of the light of the first
order, and of what is left for the later ones, is due to them. Their expected values are integrals
over the slope distribution: those of a Gaussian field, so that what a finite number of waves does
to the slopes of all surfaces alike is taken off as well.
"""

import numpy as np

from msbsdf_cli.smith.slopes import Slopes
from msbsdf_cli.smith.visible_slopes import visible_slopes
from surfaces.facet import Array, dot
from surfaces.stretch import Stretch
from surfaces.surface import Surface
from surfaces.views import VIEWS, slopes_in_view

NUMBER = 3

PER_LENGTH = 8
"""Facets a correlation length, along each axis, that are looked at: what lies between is like
them."""


def controls(surface: Surface, stretch: Stretch, wi: Array) -> Array:
    """The controls (3,) of all views of a surface, for light from the unit vector `wi` (3,)."""
    slopes = surface.slopes(max(surface.cells // PER_LENGTH, 1))
    total = np.zeros(NUMBER)
    for view in range(VIEWS):
        m = stretch.normals(slopes_in_view(slopes, np.full(1, view)))
        area = np.maximum(wi @ m, 0)
        total += [part.mean() for part in _parts(area, 2 * area / dot(m, m) - wi[2])]
    return total / VIEWS


def expected(slopes: Slopes, wi: Array) -> Array:
    """Their expected values (3,)."""
    m, area = (a[..., 0] for a in visible_slopes(slopes, -wi[:, None], split=True))
    return np.array([part.sum() for part in _parts(area, 2 * (wi @ m) * m[2] - wi[2])])


def _parts(area: Array, cos_o: Array) -> tuple[Array, Array, Array]:
    """From visible areas and the cosines of mirrored light."""
    return area, area * (cos_o > 0), area * np.maximum(cos_o, 0)
