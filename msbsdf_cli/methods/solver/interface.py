"""Surfaces that transmit: the BSDF of a dielectric, one arriving direction at a time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import betaln

from msbsdf_cli.methods.solver.dielectric import TwoSides
from msbsdf_cli.methods.solver.halfspace import ENDS
from msbsdf_cli.methods.solver.heights import Heights
from msbsdf_cli.methods.solver.isotropic import distinct_elevations, parting
from msbsdf_cli.methods.solver.nodes import Elevations
from msbsdf_cli.smith.kernel import dielectric_density
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Dielectric


@dataclass(frozen=True)
class TwoHalfSpaces:
    """All orders of a dielectric interface, at one resolution."""

    slopes: Slopes
    material: Dielectric
    orders: int
    resolution: float

    def evaluate(self, wi: Array, wo: Array) -> tuple[Array, float]:
        """BSDF x |cos(theta_o)|, (1, orders + 1, n), and the energy not accounted for."""
        value = np.zeros((self.orders + 1, wo.shape[1]))
        grid = self._directional
        flights = grid.follow(wi, self.orders)
        d = -wi[:, None]
        for side, sign in ((0, 1), (1, -1)):
            lanes = np.flatnonzero(sign * wo[2] > 0)
            for part in (lanes[i : i + ENDS] for i in range(0, lanes.size, ENDS)):
                # Inside, light is point-reflected.
                w = sign * wo[:, part]
                value[0, part] = self._single(d, w, side)
                ends, which = distinct_elevations(w)
                later = grid.emerge(flights, np.hypot(ends[0], ends[1]), ends[2], side)
                value[1:, part] = np.sum(later[..., which] * parting(d, w, grid.modes), axis=1)
        return value[None], flights.unresolved

    def _single(self, d: Array, w: Array, side: int) -> Array:
        """Order 1, in closed form: the same heights for both directions, or those of one turned
        over, which makes a beta function ([HHdD16] Eqs. 7 and 8)."""
        before = np.broadcast_to(d, w.shape)
        q = dielectric_density(self.slopes, self.material.ior, before, w)[side]
        sigma, Lambda = self.slopes.sigma(d), self.slopes.sigma(w) / w[2]
        if side == 0:
            return q / (sigma - d[2] * Lambda)
        return q * np.exp(betaln(-sigma / d[2], 1 + Lambda)) / -d[2]

    def energy(self, wi: Array) -> Array:
        """Energy (1, sides, orders + 1) that leaves in each order for `wi` (3,)."""
        grid = self._energetic
        return grid.energy(grid.follow(wi, self.orders))[None]

    @cached_property
    def _directional(self) -> TwoSides:
        return self._discretise(round(self.resolution * (24 + 24 / self.slopes.alpha_x)))

    @cached_property
    def _energetic(self) -> TwoSides:
        return self._discretise(1)

    def _discretise(self, modes: int) -> TwoSides:
        """Refraction bends less than reflection does, so that its lobes are narrower."""
        alpha = self.slopes.alpha_x
        elevations = Elevations(round(self.resolution * (16 + 4 / alpha + 10 * np.sqrt(alpha))))
        heights = Heights(round(self.resolution * 28))
        return TwoSides(self.slopes, self.material, elevations, heights, modes)
