"""Tables of the energy that leaves after one facet, which energy compensation looks up."""

from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.interpolate import CubicSpline, RectBivariateSpline

from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material
from surfaces.quadrature import gauss

POLAR_NODES = 49
AZIMUTHS = 25
"""Nodes of the albedo table from the zenith to the horizon and over a quarter turn."""

DENSER = 4.0
"""Nodes in the polar angle's coordinate s lie at sinh(DENSER u), u evenly spaced: so much denser
towards the zenith, where albedos change with the Fresnel reflectance and the roughness, than
towards the horizon, where they change as slowly as the logarithm of the cosine."""

SMOOTH = 4.0
"""Times the roughness, below 1, is what tangents are multiplied by."""

SMOOTHEST = 0.01
"""Roughness below which so little is lost, 2e-5 with Beckmann slopes, that the tables' error of
some 5e-6 is a large part of it, and with it of the lobe's normalisation."""

LOWEST = float(np.cos(np.nextafter(np.pi / 2, 0)))
"""Cosine of the last float below pi / 2, where the table ends; what lies lower counts as there."""

CHECKS = 32
"""Directions off the nodes at which a table is held against the quadrature."""
CHECKED = 6.0
"""Up to this s, a cosine of 0.005, since the table is smoothest beyond."""

MEAN_NODES = 33
"""Nodes in the squared cosine of means over the cosine."""

ROUGHNESSES = 33
"""Nodes between the smoothest and the roughest of a texture, in its logarithm."""


class Albedo:
    """A table of first-order albedos E over directions, and their mean over the cosine.

    Towards the horizon light meets facets under ever the same angles, while Lambda still grows as
    the tangent: what glass lets through goes with a small power of it, so that E keeps changing
    all the way down. In s = asinh(tan(theta)), an angle at the zenith and the logarithm of Lambda
    at the horizon, it is smooth. Of a smooth surface all energy leaves until the tangent is as
    large as the slopes are small: there s is that of the tangent times the roughness.

    The azimuth's coordinate is that of the direction
    stretched by the roots of the roughnesses, half way between the directions and the slopes.
    """

    def __init__(self, slopes: Slopes, material: Material, inside: bool) -> None:
        self.squeeze = np.sqrt(slopes.alpha_y / slopes.alpha_x)
        one = slopes.isotropic
        u = np.linspace(0, 1, POLAR_NODES)
        self.shrink = min(1.0, SMOOTH * float(np.sqrt(slopes.alpha_x * slopes.alpha_y)))
        s = np.arcsinh(self.shrink / LOWEST) * np.sinh(DENSER * u) / np.sinh(DENSER)
        azimuth = np.linspace(0, np.pi / 2, AZIMUTHS)
        columns = [
            first_order_albedo(slopes, material, self._direction(s, beta), inside)
            for beta in azimuth[: 1 if one else None]
        ]
        table = np.broadcast_to(np.stack(columns, axis=1), (POLAR_NODES, AZIMUTHS))
        self.spline = RectBivariateSpline(s, azimuth, table)
        self.mean = self._cosine_mean()
        self._of = slopes, material, inside

    def __call__(self, w: Array) -> Array:
        """E for directions (3, n) with z >= 0."""
        tangent = np.hypot(w[0], w[1]) / np.maximum(w[2], LOWEST)
        s = np.arcsinh(self.shrink * tangent)
        E = self.spline.ev(s, np.arctan2(self.squeeze * np.abs(w[1]), np.abs(w[0])))
        # Splines swing about albedos that are all but 1.
        return np.clip(np.asarray(E), 0, 1)

    def loss(self, w: Array) -> Array:
        """1 - E over its mean, (n,); 0 where nothing is lost at all."""
        mean = 1 - self.mean
        lost: Array = (1 - self(w)) / mean if mean > 0 else np.zeros(w.shape[1])
        return lost

    def _direction(self, s: Array, azimuth: Array | float) -> Array:
        """The unit vectors (3, n) of places in the table."""
        x, y = self.squeeze * np.cos(azimuth), np.sin(azimuth)
        tangent = np.sinh(s) / self.shrink
        cos = 1 / np.sqrt(1 + tangent * tangent)
        radius = cos * tangent / np.hypot(x, y)
        return np.stack([radius * x, radius * y, cos])

    def _cosine_mean(self) -> float:
        cos2, weight = (np.repeat(a, AZIMUTHS) for a in gauss(MEAN_NODES))
        phi = np.tile((np.arange(AZIMUTHS) + 0.5) * np.pi / (2 * AZIMUTHS), MEAN_NODES)
        sin = np.sqrt(1 - cos2)
        E = self(np.stack([sin * np.cos(phi), sin * np.sin(phi), np.sqrt(cos2)]))
        return float((weight * E).sum() / AZIMUTHS)

    @cached_property
    def error(self) -> float:
        """Greatest difference from the quadrature, at directions that are no nodes."""
        slopes, material, inside = self._of
        k = np.arange(CHECKS) + 0.5
        # Multiples of the golden ratio fall evenly and never on a node.
        golden = np.mod(k * (np.sqrt(5) - 1) / 2, 1)
        w = self._direction(CHECKED * k / CHECKS, np.pi / 2 * golden)
        return float(np.abs(self(w) - first_order_albedo(slopes, material, w, inside)).max())


@lru_cache(maxsize=64)
def table_of(slopes: Slopes, facets: Material, inside: bool) -> Albedo:
    """The table of lossless facets, made once for all methods and metals that read it."""
    return Albedo(slopes, facets, inside)


class TexturedAlbedo:
    """First-order albedos over direction and roughness, the same along x and y, up to a highest.

    In s = asinh(SMOOTH alpha tan(theta)) albedos of all roughnesses look much alike, so that a few
    of these will do. Below the smoothest node all light leaves, to the error of the tables.
    """

    def __init__(self, slopes: Slopes, material: Material, inside: bool) -> None:
        self.alphas = np.geomspace(min(SMOOTHEST, slopes.alpha_x / 2), slopes.alpha_x, ROUGHNESSES)
        same = [replace(slopes, alpha_x=alpha, alpha_y=alpha) for alpha in self.alphas.tolist()]
        each = [Albedo(of, material, inside) for of in same]
        u = np.linspace(0, 1, POLAR_NODES)
        s = np.arcsinh(SMOOTH * slopes.alpha_x / LOWEST) * np.sinh(DENSER * u) / np.sinh(DENSER)
        tangents = np.minimum(np.sinh(s) / (SMOOTH * self.alphas[:, None]), 1 / LOWEST)
        rows = [E(_of_tangent(tangent)) for E, tangent in zip(each, tangents, strict=True)]
        self.spline = RectBivariateSpline(self.alphas, s, np.array(rows))
        self.means = CubicSpline(self.alphas, [E.mean for E in each])
        self._of = slopes, material, inside

    @cached_property
    def error(self) -> float:
        """Greatest difference from the quadrature, half way between the roughnesses."""
        slopes, material, inside = self._of
        w = _of_tangent(np.sinh(np.linspace(0, CHECKED, CHECKS)))
        off = []
        for alpha in np.sqrt(self.alphas[1:] * self.alphas[:-1]).tolist():
            of = replace(slopes, alpha_x=alpha, alpha_y=alpha)
            truth = first_order_albedo(of, material, w, inside)
            off.append(np.abs(AlbedoOfLanes(self, np.full(CHECKS, alpha))(w) - truth).max())
        return float(max(off))


class AlbedoOfLanes:
    """What a `TexturedAlbedo` says for lanes of roughness `alpha` (n,); used as `Albedo` is.

    Raises ValueError where that is above the table's highest.
    """

    def __init__(self, table: TexturedAlbedo, alpha: Array) -> None:
        lowest, highest = table.alphas[[0, -1]]
        if alpha.max(initial=0) > highest:
            raise ValueError(f"roughness {alpha.max():g} is above {highest:g}, where a table ends.")
        self.table, self.alpha = table, alpha
        self.mean = np.clip(table.means(np.maximum(alpha, lowest)), 0, 1)

    @property
    def error(self) -> float:
        """That of the table."""
        return self.table.error

    def __call__(self, w: Array) -> Array:
        """E for directions (3, n) with z >= 0."""
        tangent = np.hypot(w[0], w[1]) / np.maximum(w[2], LOWEST)
        s = np.arcsinh(SMOOTH * self.alpha * tangent)
        return np.clip(np.asarray(self.table.spline.ev(self.alpha, s)), 0, 1)

    def loss(self, w: Array) -> Array:
        """1 - E over its mean, (n,); 0 where nothing is lost at all."""
        lost, mean = 1 - self(w), 1 - self.mean
        return np.divide(lost, mean, out=np.zeros_like(lost), where=mean > 0)


def roughness_of_lanes(slopes: Slopes) -> Array:
    """The roughness (n,) of lanes. Raises UnsupportedError where there are two."""
    if not np.array_equal(slopes.alpha_x, slopes.alpha_y):
        raise UnsupportedError(
            "energy is compensated by tables over one roughness, and a texture has two"
        )
    return np.asarray(slopes.alpha_x)


def _of_tangent(tangent: Array) -> Array:
    """Directions (3, n) of azimuth 0."""
    cos = 1 / np.sqrt(1 + tangent * tangent)
    return np.stack([tangent * cos, np.zeros_like(cos), cos])
