"""What renderers ship instead: single scattering and a lobe that makes up for the energy."""

from collections.abc import Callable
from copy import copy
from functools import cached_property
from typing import Self

import numpy as np

from msbsdf_cli.methods.albedo_table import (
    MEAN_NODES,
    SMOOTHEST,
    Albedo,
    AlbedoOfLanes,
    TexturedAlbedo,
    roughness_of_lanes,
    table_of,
)
from msbsdf_cli.methods.base import MethodBase, Outgoing, outgoing
from msbsdf_cli.methods.protocol import Evaluation, UnsupportedError
from msbsdf_cli.methods.single import first_order, first_order_of_each, phase_density
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, unit_circle
from surfaces.materials import Material
from surfaces.quadrature import gauss


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
        one_roughness_textured=True,
        energy_error={"conductor": 1e-3, "dielectric": 1e-2},
        energy_error_because="table of albedos",
    )
    deterministic = True

    def __init__(self, slopes: Slopes, material: Material, orders: int) -> None:
        super().__init__(slopes, material, orders)
        self.E: Albedo | AlbedoOfLanes = table_of(slopes, material.lossless, False)
        self.E_inside: Albedo | AlbedoOfLanes = self.E
        if material.transmits:
            self.E_inside = table_of(slopes, material.lossless, True)

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
        value[:, -1] = self._lobe(wi[:, None], out)
        stderr[:, -1] = self.E.error * self._shape(out)
        return Evaluation(value, stderr)

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        w, again = self._directions(wi[:, None], n, rng)
        value = self.evaluate(wi, w, 0, rng).value.sum(axis=1)
        return w, np.where(again, 0, value / np.where(again, 1, self.pdf(wi, w)))

    def pdf(self, wi: Array, wo: Array) -> Array:
        """The density of `sample`, (n,)."""
        return self.pdf_each(wi[:, None], wo)

    def of_lanes(self, slopes: Slopes, material: Material) -> Self:
        if not slopes.textured:
            return self
        lanes, alpha = copy(self), roughness_of_lanes(slopes)
        lanes.slopes = slopes
        lanes.E = AlbedoOfLanes(self.textured[0], alpha)
        lanes.E_inside = AlbedoOfLanes(self.textured[-1], alpha)
        return lanes

    @cached_property
    def textured(self) -> list[TexturedAlbedo]:
        """Albedos from either side over all roughnesses up to this one."""
        sides = (False, True) if self.material.transmits else (False,)
        return [TexturedAlbedo(self.slopes, self.material, inside) for inside in sides]

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        out = outgoing(self.slopes, wo)
        first = first_order_of_each(self.slopes, self.material, wi, out, rng)
        return first + self._lobe(wi, out)

    def sample_each(self, wi: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        w, again = self._directions(wi, wi.shape[1], rng)
        density = np.where(again, 1, self.pdf_each(wi, w))
        return w, np.where(again, 0, self.evaluate_each(wi, w, rng) / density)

    def pdf_each(self, wi: Array, wo: Array) -> Array:
        E_i, through = self.E(wi), self._through
        cosine = np.where(wo[2] < 0, through, 1 - through) * np.abs(wo[2]) / np.pi
        return E_i * phase_density(self.slopes, self.material, wi, wo) + (1 - E_i) * cosine

    def _directions(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """The first facet by visible normals, or a cosine lobe, as their energies are; and where
        the facet sends light back to the surface, whose weight is 0."""
        m = self.slopes.visible_normals(wi, n, rng)
        w, _, transmitted = self.material.scatter(-wi, m, None, rng)
        through = np.zeros(n, bool) if transmitted is None else transmitted
        again = through == (w[2] > 0)
        lobe = np.flatnonzero(rng.random(n) >= self.E(wi))
        cos_phi, sin_phi = unit_circle(lobe.size, rng, wi.dtype.type)
        radius2 = rng.random(lobe.size, dtype=wi.dtype)
        below = rng.random(lobe.size) < np.broadcast_to(self._through, (n,))[lobe]
        side = np.where(below, -1, 1)
        w[:, lobe] = np.stack(
            [np.sqrt(radius2) * cos_phi, np.sqrt(radius2) * sin_phi, side * np.sqrt(1 - radius2)]
        )
        again[lobe] = False
        return w, again

    def _lobe(self, wi: Array, out: Outgoing) -> Array:
        """The compensation, BSDF x cos(theta_o), (channels, n), for `wi` (3, 1) or (3, n)."""
        return (1 - self.E(wi)) * self._shape(out)

    def _shape(self, out: Outgoing) -> Array:
        """The compensation for one unit of lost energy, per steradian, (channels, n)."""
        cosine = out.w[2] / np.pi
        above = self.E.loss(out.w) * cosine
        if not self.material.transmits:
            return self._bounced_again() * np.where(out.inside, 0, above)
        below, through = self.E_inside.loss(out.w) * cosine, self._through
        return np.where(out.inside, through * below, (1 - through) * above)[None]

    def _bounced_again(self) -> Array:
        """What of the lost energy a metal returns after more bounces, (channels, 1) or (channels,
        n)."""
        F = _cosine_mean(self.material.reflectance)[:, None]
        return F * F * self.E.mean / (1 - F * (1 - self.E.mean))

    @property
    def _through(self) -> Array:
        """Share of the lost energy that leaves inside, () or (n,).

        Fresnel's law is reciprocal, (1 - Fbar) = ior^2 (1 - Fbar_inside); times the mean loss of
        the other side it makes the two lobes reciprocal, and the larger loss keeps it below 1.
        """
        if not self.material.transmits:
            return np.zeros(())
        F = _cosine_mean(self.material.reflectance)[0]
        lost, lost_inside = np.asarray(1 - self.E.mean), np.asarray(1 - self.E_inside.mean)
        most = np.maximum(lost, lost_inside)
        return np.divide((1 - F) * lost_inside, most, out=np.zeros_like(most), where=most > 0)


def _cosine_mean(fresnel: Callable[[Array], Array]) -> Array:
    """Mean reflectance (channels,) over the hemisphere, 2 times the integral of F cos dcos."""
    cos_i, weight = gauss(MEAN_NODES)
    return 2 * (fresnel(cos_i) * weight * cos_i).sum(axis=-1)
