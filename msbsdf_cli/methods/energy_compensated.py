"""What renderers ship instead: single scattering and a lobe that makes up for the energy."""

from collections.abc import Callable

import numpy as np
from scipy.interpolate import RectBivariateSpline

from msbsdf_cli.methods.base import MethodBase, Outgoing, outgoing
from msbsdf_cli.methods.protocol import Evaluation, UnsupportedError
from msbsdf_cli.methods.single import first_order, phase_density
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, unit_circle
from surfaces.materials import Material

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
        one = slopes.alpha_x == slopes.alpha_y
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
        self.error = self._error(slopes, material, inside)
        """Greatest difference from the quadrature, at directions that are no nodes."""

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
        x, weight = np.polynomial.legendre.leggauss(MEAN_NODES)
        cos2, weight = np.repeat((1 + x) / 2, AZIMUTHS), np.repeat(weight / 2, AZIMUTHS)
        phi = np.tile((np.arange(AZIMUTHS) + 0.5) * np.pi / (2 * AZIMUTHS), MEAN_NODES)
        sin = np.sqrt(1 - cos2)
        E = self(np.stack([sin * np.cos(phi), sin * np.sin(phi), np.sqrt(cos2)]))
        return float((weight * E).sum() / AZIMUTHS)

    def _error(self, slopes: Slopes, material: Material, inside: bool) -> float:
        k = np.arange(CHECKS) + 0.5
        # Multiples of the golden ratio fall evenly and never on a node.
        golden = np.mod(k * (np.sqrt(5) - 1) / 2, 1)
        w = self._direction(CHECKED * k / CHECKS, np.pi / 2 * golden)
        return float(np.abs(self(w) - first_order_albedo(slopes, material, w, inside)).max())


class EnergyCompensated(MethodBase):
    """Single scattering as it is, in order 1, and one lobe for all later orders, in the last row.

    Kulla & Conty 2017, Revisiting Physically Based Shading at Imageworks:
    (1 - E_i) (1 - E_o) / (pi (1 - Ebar)) with the share Fbar^2 Ebar / (1 - Fbar (1 - Ebar)) of a
    metal; reciprocal. On a dielectric the missing energy is split between two such lobes, one on
    each side, in the proportion of the mean Fresnel reflectances, adjusted to be reciprocal.

    No noise: albedos come from a table made once, by quadrature. Its error, which is that of the
    energy, is stated as the standard error of the lobe.
    """

    name = "energy-compensated"
    traits = Traits(
        "#56b4e9",
        "*",
        model="energy-compensated",
        energy_error={"conductor": 1e-3, "dielectric": 1e-2},
        energy_error_because="table of albedos",
    )
    deterministic = True

    def __init__(self, slopes: Slopes, material: Material, orders: int) -> None:
        super().__init__(slopes, material, orders)
        self.E = Albedo(slopes, material, inside=False)
        self.E_inside = Albedo(slopes, material, inside=True) if material.transmits else self.E
        self.through = self._share_through()

    @classmethod
    def check_supported(cls, slopes: Slopes, material: Material) -> None:
        super().check_supported(slopes, material)
        if not material.specular:
            raise UnsupportedError(
                "method energy-compensated is for conductors and dielectrics: diffuse facets lose "
                "no energy to a closed form that anybody would compensate"
            )
        if slopes.alpha_x * slopes.alpha_y < SMOOTHEST**2:
            raise UnsupportedError(
                f"method {cls.name} has nothing to compensate at roughness "
                f"{slopes.alpha_x:g},{slopes.alpha_y:g}: what a single bounce loses is less than "
                "the error of its tables; single is the method to take"
            )

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        out = outgoing(self.slopes, wo.astype(wi.dtype, copy=False))
        value = np.zeros((self.material.channels, self.orders + 1, out.n), wi.dtype)
        stderr = np.zeros_like(value)
        value[:, 0] = first_order(self.slopes, self.material, wi, out)
        value[:, -1] = self._lobe(wi, out)
        stderr[:, -1] = self.E.error * self._shape(out)
        return Evaluation(value, stderr)

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """The first facet by visible normals, or a cosine lobe, as their energies are; the weight
        is 0 where the facet sends light back to the surface."""
        d = -wi[:, None]
        m = self.slopes.visible_normals(-d, n, rng)
        w, _, transmitted = self.material.scatter(d, m, None, rng)
        through = np.zeros(n, bool) if transmitted is None else transmitted
        again = through == (w[2] > 0)
        lobe = np.flatnonzero(rng.random(n) >= self.E(wi[:, None])[0])
        cos_phi, sin_phi = unit_circle(lobe.size, rng, wi.dtype.type)
        radius2 = rng.random(lobe.size, dtype=wi.dtype)
        side = np.where(rng.random(lobe.size) < self.through, -1, 1)
        w[:, lobe] = np.stack(
            [np.sqrt(radius2) * cos_phi, np.sqrt(radius2) * sin_phi, side * np.sqrt(1 - radius2)]
        )
        again[lobe] = False
        value = self.evaluate(wi, w, 0, rng).value.sum(axis=1)
        density = self.pdf(wi, w)
        return w, np.where(again, 0, value / np.where(again, 1, density))

    def pdf(self, wi: Array, wo: Array) -> Array:
        """The density of `sample`, (n,)."""
        E_i = self.E(wi[:, None])[0]
        side = np.where(wo[2] < 0, self.through, 1 - self.through)
        cosine = side * np.abs(wo[2]) / np.pi
        return E_i * phase_density(self.slopes, self.material, wi, wo) + (1 - E_i) * cosine

    def _lobe(self, wi: Array, out: Outgoing) -> Array:
        """The compensation, BSDF x cos(theta_o), (channels, n)."""
        return (1 - self.E(wi[:, None])) * self._shape(out)

    def _shape(self, out: Outgoing) -> Array:
        """The compensation for one unit of lost energy, per steradian, (channels, n)."""
        cosine = out.w[2] / np.pi
        above = self.E.loss(out.w) * cosine
        if not self.material.transmits:
            return self._bounced_again()[:, None] * np.where(out.inside, 0, above)
        below = self.E_inside.loss(out.w) * cosine
        return np.where(out.inside, self.through * below, (1 - self.through) * above)[None]

    def _bounced_again(self) -> Array:
        """What of the lost energy a metal returns after more bounces, (channels,)."""
        F = _cosine_mean(self.material.reflectance)
        return F * F * self.E.mean / (1 - F * (1 - self.E.mean))

    def _share_through(self) -> float:
        """Share of the lost energy that leaves inside.

        Fresnel's law is reciprocal, (1 - Fbar) = ior^2 (1 - Fbar_inside); times the mean loss of
        the other side it makes the two lobes reciprocal, and the larger loss keeps it below 1.
        """
        if not self.material.transmits:
            return 0.0
        F = _cosine_mean(self.material.reflectance)
        lost, lost_inside = 1 - self.E.mean, 1 - self.E_inside.mean
        most = max(lost, lost_inside)
        return float((1 - F[0]) * lost_inside / most) if most > 0 else 0.0


def _cosine_mean(fresnel: Callable[[Array], Array]) -> Array:
    """Mean reflectance (channels,) over the hemisphere, 2 times the integral of F cos dcos."""
    x, weight = np.polynomial.legendre.leggauss(MEAN_NODES)
    cos_i = (1 + x) / 2
    return (fresnel(cos_i) * weight * cos_i).sum(axis=-1)
