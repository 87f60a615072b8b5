"""What renderers ship instead: single scattering and a lobe that makes up for the energy."""

from collections.abc import Callable

import numpy as np
from scipy.interpolate import RectBivariateSpline

from msbsdf_cli.methods.directions import Exits, Holds, exits
from msbsdf_cli.methods.protocol import Evaluation, UnsupportedError
from msbsdf_cli.methods.single import first_order, phase_density
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, fresnel_dielectric, unit_circle
from surfaces.materials import Conductor, Dielectric, Material

POLAR_NODES = 33
AZIMUTHS = 7
"""Nodes of the albedo table from the zenith to the horizon and over a quarter turn; cubic splines
between them are right to 3e-4 for conductors, and to 5e-3 for dielectrics near grazing."""


class Albedo:
    """A table of first-order albedos E over directions, and their mean over the cosine."""

    def __init__(self, slopes: Slopes, material: Material, inside: bool) -> None:
        theta = np.linspace(0, np.pi / 2, POLAR_NODES)
        # At the horizon itself all facets that are seen are seen edge-on.
        theta[-1] -= 1e-6
        phi = np.linspace(0, np.pi / 2, AZIMUTHS)
        if slopes.alpha_x == slopes.alpha_y:
            first = self._column(slopes, material, theta, np.zeros_like(theta), inside)
            table = np.repeat(first[:, None], AZIMUTHS, axis=1)
        else:
            columns = [
                self._column(slopes, material, theta, np.full_like(theta, p), inside) for p in phi
            ]
            table = np.stack(columns, axis=1)
        self.spline = RectBivariateSpline(theta, phi, table)
        x, weight = np.polynomial.legendre.leggauss(POLAR_NODES)
        cos2 = (1 + x) / 2
        mean = [
            (weight / 2 * self.spline.ev(np.arccos(np.sqrt(cos2)), np.full_like(x, p))).sum()
            for p in (np.arange(AZIMUTHS) + 0.5) * np.pi / (2 * AZIMUTHS)
        ]
        self.mean = float(np.mean(mean))

    def __call__(self, w: Array) -> Array:
        """E for directions (3, n) with z >= 0."""
        theta = np.arctan2(np.hypot(w[0], w[1]), w[2])
        return np.asarray(self.spline.ev(theta, np.arctan2(np.abs(w[1]), np.abs(w[0]))))

    @staticmethod
    def _column(
        slopes: Slopes, material: Material, theta: Array, phi: Array, inside: bool
    ) -> Array:
        s = np.sin(theta)
        w = np.stack([s * np.cos(phi), s * np.sin(phi), np.cos(theta)])
        return first_order_albedo(slopes, material, w, inside)


class EnergyCompensated(Holds):
    """Single scattering as it is, in order 1, and one lobe for all later orders, in the last row.

    `variant` "kulla-conty" (Kulla & Conty 2017, Revisiting Physically Based Shading at Imageworks):
    (1 - E_i) (1 - E_o) / (pi (1 - Ebar)) with the share Fbar^2 Ebar / (1 - Fbar (1 - Ebar)) of a
    metal; reciprocal. On a dielectric the missing energy is split between two such lobes, one on
    each side, in the proportion of the mean Fresnel reflectances, adjusted to be reciprocal.

    `variant` "turquin" (Turquin 2019, Practical Multiple Scattering Compensation for Microfacet
    Models): single scattering times F0 (1 - E_i) / E_i; conductors only, not reciprocal.

    No noise: albedos come from a table made once, by quadrature.
    """

    name = "energy-compensated"
    deterministic = True

    def __init__(
        self, slopes: Slopes, material: Material, orders: int, variant: str = "kulla-conty"
    ) -> None:
        self.refuse(slopes, material)
        if variant == "turquin" and isinstance(material, Dielectric):
            raise UnsupportedError(
                "the variant turquin of energy-compensated is for conductors only"
            )
        self.slopes, self.material, self.orders = slopes, material, orders
        self.variant = variant
        self.E = Albedo(slopes, material, inside=False)
        self.E_inside = Albedo(slopes, material, inside=True) if material.transmits else self.E
        self.through = self._share_through()

    @classmethod
    def refuse(cls, slopes: Slopes, material: Material) -> None:
        super().refuse(slopes, material)
        if not isinstance(material, Conductor | Dielectric):
            raise UnsupportedError(
                "method energy-compensated is for conductors and dielectrics: diffuse facets lose "
                "no energy to a closed form that anybody would compensate"
            )

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        out = exits(self.slopes, wo.astype(wi.dtype, copy=False))
        value = np.zeros((self.material.channels, self.orders + 1, out.n), wi.dtype)
        value[:, 0] = first_order(self.slopes, self.material, wi, out)
        if self.variant == "turquin":
            E_i = self.E(wi[:, None])
            value[:, -1] = value[:, 0] * self._at_normal_incidence()[:, None] * (1 - E_i) / E_i
        else:
            value[:, -1] = self._lobe(wi, out)
        return Evaluation(value, np.zeros_like(value))

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

    def _lobe(self, wi: Array, out: Exits) -> Array:
        """The compensation, BSDF x cos(theta_o), (channels, n)."""
        lost = 1 - self.E(wi[:, None])
        above = (1 - self.E(out.w)) / (1 - self.E.mean)
        cosine = lost * out.w[2] / np.pi
        if not self.material.transmits:
            return self._bounced_again()[:, None] * np.where(out.inside, 0, above * cosine)
        below = (1 - self.E_inside(out.w)) / (1 - self.E_inside.mean)
        share = np.where(out.inside, self.through * below, (1 - self.through) * above)
        return (share * cosine)[None]

    def _bounced_again(self) -> Array:
        """What of the lost energy a metal returns after more bounces, (channels,)."""
        F = _cosine_mean(self._fresnel)
        return F * F * self.E.mean / (1 - F * (1 - self.E.mean))

    def _share_through(self) -> float:
        """Share of the lost energy that leaves inside.

        Fresnel's law is reciprocal, (1 - Fbar) = ior^2 (1 - Fbar_inside); times the mean loss of
        the other side it makes the two lobes reciprocal, and the larger loss keeps it below 1.
        """
        if not isinstance(self.material, Dielectric):
            return 0.0
        ior = self.material.ior
        F = _cosine_mean(lambda cos_i: fresnel_dielectric(cos_i, ior)[0][None])
        lost, lost_inside = 1 - self.E.mean, 1 - self.E_inside.mean
        return float((1 - F[0]) * lost_inside / max(lost, lost_inside))

    def _fresnel(self, cos_i: Array) -> Array:
        assert isinstance(self.material, Conductor)
        if not self.material.absorbs:
            return np.ones((1, cos_i.size))
        return self.material.fresnel(cos_i)

    def _at_normal_incidence(self) -> Array:
        return self._fresnel(np.ones(1))[:, 0]


def _cosine_mean(fresnel: Callable[[Array], Array]) -> Array:
    """Mean reflectance (channels,) over the hemisphere, 2 times the integral of F cos dcos."""
    x, weight = np.polynomial.legendre.leggauss(POLAR_NODES)
    cos_i = (1 + x) / 2
    return (fresnel(cos_i) * weight * cos_i).sum(axis=-1)
