"""`solve`: the Smith model without noise, all orders and all pairs of directions at once."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.methods.base import MethodBase, outgoing
from msbsdf_cli.methods.protocol import Evaluation, UnsupportedError
from msbsdf_cli.methods.single import first_order
from msbsdf_cli.methods.solver.dielectric import DielectricSolution
from msbsdf_cli.methods.solver.first_order import first_order_energy
from msbsdf_cli.methods.solver.opaque import OpaqueSolution
from msbsdf_cli.methods.solver.size import needed_bytes
from msbsdf_cli.methods.traits import Traits
from msbsdf_cli.run.memory import gigabytes, memory_bytes
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array, fresnel_dielectric
from surfaces.materials import Material

COARSER = (0.75,)
COARSER_OF_RIPPLES = (0.75, 0.5)
"""Resolutions of further solutions; the difference from the first estimates the error, which falls
by more than a half between the two. Directional values of dielectrics and all values of a grid of
directions are interpolated, and ripple about the right ones: two that differ little may both be
off, and the second is there to show it."""

ENERGY_KNOWN = 1e-3
VALUE_KNOWN = 1e-2
"""Stated errors that need a word of warning: of an order's energy, five times the largest that is
promised, and of values, a part of the largest, the error of a picture that nobody would see."""

REFINEMENT = 1.5
REFINEMENTS = 5
REFINEMENTS_OF_TWO = 3
"""Factor between resolutions, and how many are tried, where an accuracy is asked for: up to 5, or
2.25 for two roughnesses, whose memory grows by the fourth power."""


PANEL = 20
"""Nodes between edges of the first order that energies are checked with; it is right to 1e-5."""

NO_SAMPLER = "solve evaluates a BSDF without samples, and has no sampler of its own"

COSINES = np.linspace(0.05, 1, 20)
"""Cosines at which facets are asked whether they are those that the equations are for."""


@dataclass(frozen=True)
class Energy:
    """Energy that leaves, as a fraction of what arrives, in orders 1 to K and then all later ones.

    Arrays are (channels, orders + 1).
    """

    reflected: Array
    transmitted: Array
    error: Array
    """Error estimate of both together, from several resolutions and from what the sum misses."""


class Solve(MethodBase):
    """The integral equation of the Smith model, discretised and solved, for orders up to infinity.

    Same model as the random walk of [HHdD16], Algorithm 1. Arithmetic is in float64; results are
    in the precision of `wi`.
    """

    name = "solve"
    traits = Traits("#0072b2", "P", samples=False, pairs=False)
    deterministic = True

    def __init__(
        self, slopes: Slopes, material: Material, orders: int, resolution: float = 1.0
    ) -> None:
        """`resolution` multiplies the number of nodes in each angle and in height. At 1, energies
        of conductors and diffuse facets are right to 1e-6 (roughness 0.1 to 10), and those of
        dielectrics to some 1e-6; of roughness 0.1,1 up to theta 1.57, mirrors and diffuse facets to
        5e-6, glass to 2e-5 (Beckmann) and 3e-4 (GGX). At 2 dielectrics of one roughness are right
        to 3e-7. Towards grazing angles lobes of narrow roughness are narrower than the nodes, and
        directional values there are less accurate: `stderr` shows it.
        """
        super().__init__(slopes, material, orders)
        ripples = slopes.alpha_x != slopes.alpha_y or material.transmits
        coarser = COARSER_OF_RIPPLES if ripples else COARSER
        self.fine, *self.coarse = (
            solution(slopes, material, orders, r * resolution) for r in (1, *coarser)
        )

    @classmethod
    def check_supported(cls, slopes: Slopes, material: Material) -> None:
        super().check_supported(slopes, material)
        need, have = needed_bytes(slopes, material), memory_bytes()
        if need > have:
            raise UnsupportedError(
                f"method {cls.name} needs about {gigabytes(need)} of memory at roughness "
                f"{slopes.alpha_x:g},{slopes.alpha_y:g}, and this machine has {gigabytes(have)}"
            )
        if not material.specular and not np.allclose(material.lobe(COSINES), COSINES / np.pi):
            raise UnsupportedError(
                f"method {cls.name} is not for {material.name} facets: of those that are not "
                "specular, its equations are for Lambertian ones"
            )
        fresnel = fresnel_dielectric(COSINES, material.ior)[0]
        if material.transmits and not np.allclose(material.reflectance(COSINES), fresnel):
            raise UnsupportedError(
                f"method {cls.name} is not for {material.name} facets: of those that transmit, its "
                "equations are for interfaces with the reflectance of Fresnel's law"
            )

    @classmethod
    def accurate(
        cls, slopes: Slopes, material: Material, orders: int, wi: Array, accuracy: float
    ) -> "Solve":
        """At the lowest of resolutions 1, 1.5, 2.25 ... that by its own estimate knows each order's
        energy to `accuracy`, for light from any of `wi` (3, n); or the best of them. Raises
        ArithmeticError where none comes to an end.
        """
        one = slopes.isotropic
        found, failure = [], None
        for step in range(REFINEMENTS if one else REFINEMENTS_OF_TWO):
            solution = cls(slopes, material, orders, REFINEMENT**step)
            try:
                error = max(float(solution.energy(d).error.max()) for d in wi.T)
            except ArithmeticError as too_coarse:
                failure = too_coarse
                continue
            found.append((error, solution))
            if error <= accuracy:
                break
        if failure is not None and not found:
            raise failure
        return min(found, key=lambda pair: pair[0])[1]

    def evaluate(
        self, wi: Array, wo: Array, samples: int = 0, rng: np.random.Generator | None = None
    ) -> Evaluation:
        """Evaluate for a unit vector `wi` (3,), z > 0, and unit vectors `wo` (3, n), z either sign.

        `samples` and `rng` are not used. `stderr` is the greatest difference of resolutions; the
        first order is that of `single`, without one.
        """
        value, error, unresolved = self.pairs(wi.astype(float)[:, None], wo.astype(float))
        return Evaluation(value[0].astype(wi.dtype), error[0].astype(wi.dtype), unresolved)

    def pairs(self, wi: Array, wo: Array) -> tuple[Array, Array, float]:
        """Values and errors, (m, channels, orders + 1, n) each, between all of `wi` (3, m) and all
        of `wo` (3, n), and the energy not accounted for: faster than one `wi` after the other."""
        value, unresolved = self.fine.pairs(wi, wo)
        error = np.max([np.abs(value - c.pairs(wi, wo)[0]) for c in self.coarse], axis=0)
        # Ripples about a value that is nearly 0 go below it.
        error = np.maximum(error, -value)
        value, out = np.maximum(value, 0), outgoing(self.slopes, wo)
        value[:, :, 0] = [first_order(self.slopes, self.material, w, out) for w in wi.T]
        return value, error, unresolved

    def energy(self, wi: Array) -> Energy:
        """Energy of each order that leaves, for a unit vector `wi` (3,), z > 0."""
        one = self.slopes.isotropic
        fine, *coarse = (
            s.energy(wi.astype(float)) for s in (self.fine, *self.coarse[: 1 if one else None])
        )
        error = _error(fine, coarse)
        if not self.material.absorbs:
            error = _answering_for(np.abs(1 - fine.sum(axis=(1, 2))), error)
        if self.material.transmits:
            # All resolutions may agree and be wrong in the last floats above the horizon, where
            # light meets none but the highest facets; the first order tells by how much.
            first = first_order_energy(self.slopes, self.material, wi.astype(float), PANEL)
            error = np.maximum(error, abs(float(fine[0, :, 0].sum()) - first))
        return Energy(fine[:, 0], fine[:, 1], error)

    def albedo(self, wi: Array) -> tuple[Array, Array]:
        """Energy of each order, both sides, and its error estimate, (channels, orders + 1)."""
        energy = self.energy(wi)
        return energy.reflected + energy.transmitted, energy.error

    def sample(self, wi: Array, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
        """Not offered."""
        raise UnsupportedError(NO_SAMPLER)

    def pdf(self, wi: Array, wo: Array) -> Array:
        """Not offered."""
        raise UnsupportedError(NO_SAMPLER)


def _error(fine: Array, coarse: list[Array]) -> Array:
    """Error estimate (channels, orders + 1) of energies (channels, sides, orders + 1).

    The difference from the next coarser solution vanishes by chance where the errors of two grids
    cross, and that from the coarsest is far too large: the geometric mean of it and the greatest.
    """
    differences = np.array([np.abs(fine - c).sum(axis=1) for c in coarse])
    error: Array = np.sqrt(differences[0] * differences.max(axis=0))
    return error


def _answering_for(missing: Array, error: Array) -> Array:
    """Error estimates (channels, orders + 1) that together are no less than the energy (channels,)
    by which the sum over all orders, known to be 1, is missed: in the same proportions."""
    total = error.sum(axis=1)
    # Where resolutions do not differ at all, nothing says which order it is.
    share = np.divide(error, total[:, None], out=np.ones_like(error), where=total[:, None] > 0)
    answering: Array = share * np.maximum(total, missing)[:, None]
    return answering


def solution(
    slopes: Slopes, material: Material, orders: int, resolution: float
) -> OpaqueSolution | DielectricSolution:
    """All orders but the first, at one resolution."""
    kind = DielectricSolution if material.transmits else OpaqueSolution
    return kind(slopes, material, orders, resolution)
