"""What Blender ships: single scattering, brightened until the energy is right."""

from copy import copy
from functools import cached_property
from typing import Self

import numpy as np

from msbsdf_cli.methods.albedo_table import (
    Albedo,
    AlbedoOfLanes,
    TexturedAlbedo,
    roughness_of_lanes,
    table_of,
)
from msbsdf_cli.methods.base import MethodBase, outgoing
from msbsdf_cli.methods.protocol import Evaluation, UnsupportedError
from msbsdf_cli.methods.single import Single, first_order, first_order_of_each
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.smith.albedo import first_order_albedo
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Material

LEAST_ALBEDO = 1e-3
"""Of a single bounce at normal incidence; below, all light of a picture would come from one sample
in thousands."""


class Turquin(MethodBase):
    """Single scattering in order 1, and F0 (1 - E_i) / E_i times it for all later orders (Turquin
    2019, Practical Multiple Scattering Compensation for Microfacet Models); not reciprocal.

    No noise: the albedo E_i comes from a table made once, by quadrature, whose error is stated.
    """

    name = "turquin"
    traits = Traits(
        "#999933",
        "<",
        model="turquin",
        one_roughness_textured=True,
        reciprocal=False,
        energy_error={"conductor": 1e-3},
        energy_error_because="table of albedos",
    )
    deterministic = True

    def __init__(self, slopes: Slopes, material: Material, orders: int) -> None:
        super().__init__(slopes, material, orders)
        self.single = Single(slopes, material, orders)
        self.E: Albedo | AlbedoOfLanes = table_of(slopes, material.lossless, False)
        self.F0 = material.reflectance(np.ones(1))[:, 0]

    @classmethod
    def check_supported(cls, slopes: Slopes, material: Material) -> None:
        super().check_supported(slopes, material)
        if not material.specular or material.transmits:
            raise UnsupportedError("method turquin is for conductors: F0 is the colour of a metal")
        zenith = np.array([[0.0], [0.0], [1.0]])
        if first_order_albedo(slopes, material, zenith)[0] < LEAST_ALBEDO:
            raise UnsupportedError(
                f"method turquin is not for roughness {slopes.alpha_x:g},{slopes.alpha_y:g}: it "
                "brightens what a single bounce returns, and that is next to nothing"
            )

    def evaluate(self, wi: Array, wo: Array, samples: int, rng: np.random.Generator) -> Evaluation:
        out = outgoing(self.slopes, wo.astype(wi.dtype, copy=False))
        value = np.zeros((self.material.channels, self.orders + 1, out.n), wi.dtype)
        stderr = np.zeros_like(value)
        value[:, 0] = first_order(self.slopes, self.material, wi, out)
        value[:, -1] = value[:, 0] * self._added(wi[:, None])
        E_i = self.E(wi[:, None])
        stderr[:, -1] = value[:, 0] * (self.F0[:, None] * self.E.error / E_i**2)
        return Evaluation(value, stderr)

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """As single scattering, brightened."""
        w, weight = self.single.sample(wi, n, rng)
        return w, weight * (1 + self._added(wi[:, None]))

    def pdf(self, wi: Array, wo: Array) -> Array:
        """The density of `sample`; what it sends back into the surface is missing from it."""
        return self.single.pdf(wi, wo)

    def of_lanes(self, slopes: Slopes, material: Material) -> Self:
        if not slopes.textured:
            return self
        lanes, alpha = copy(self), roughness_of_lanes(slopes)
        lanes.slopes, lanes.single = slopes, self.single.of_lanes(slopes, material)
        lanes.E = AlbedoOfLanes(self.textured, alpha)
        return lanes

    @cached_property
    def textured(self) -> TexturedAlbedo:
        """Albedos over all roughnesses up to this one."""
        return TexturedAlbedo(self.slopes, self.material, inside=False)

    def evaluate_each(self, wi: Array, wo: Array, rng: np.random.Generator) -> Array:
        out = outgoing(self.slopes, wo)
        first = first_order_of_each(self.slopes, self.material, wi, out, rng)
        return first * (1 + self._added(wi))

    def sample_each(self, wi: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        w, weight = self.single.sample_each(wi, rng)
        return w, weight * (1 + self._added(wi))

    def pdf_each(self, wi: Array, wo: Array) -> Array:
        return self.single.pdf_each(wi, wo)

    def _added(self, wi: Array) -> Array:
        """What the later orders are of the first, (channels, n), for `wi` (3, n)."""
        E_i = self.E(wi)
        return self.F0[:, None] * (1 - E_i) / E_i
