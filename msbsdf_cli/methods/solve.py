"""`solve`: the Smith model without noise, all orders and all pairs of directions at once."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.methods.protocol import Evaluation, NotForThis
from msbsdf_cli.methods.solver.halfspace import HalfSpace
from msbsdf_cli.smith.slopes import Slopes
from surfaces.facet import Array
from surfaces.materials import Conductor, Diffuse, Material

COARSER = 0.75
"""Resolution of the second solution, whose difference from the first estimates its error. The
error falls by far more than a half between the two, so that the estimate is on the safe side."""


@dataclass(frozen=True)
class Energy:
    """Energy that leaves, as a fraction of what arrives, in orders 1 to K and then all later ones.

    Arrays are (channels, orders + 1).
    """

    reflected: Array
    transmitted: Array
    error: Array
    """Error estimate of the sum of both, from two resolutions."""


class Solve:
    """The integral equation of the Smith model, discretised and solved, for orders up to infinity.

    Same model as the random walk of [HHdD16], Algorithm 1. Arithmetic is in float64; results are
    in the precision of `wi`.
    """

    name = "solve"

    def __init__(
        self, slopes: Slopes, material: Material, orders: int, resolution: float = 1.0
    ) -> None:
        """`resolution` multiplies the number of nodes: 1 aims at errors of energy below 1e-6 for
        roughness 0.05 to 5; convergence is exponential for mirrors, of third order otherwise.
        Raises NotForThis for materials that cannot be solved.
        """
        if not isinstance(material, Conductor | Diffuse):
            raise NotForThis(f"solve does not know {material.name} facets")
        self.fine = HalfSpace(slopes, material, orders, resolution)
        self.coarse = HalfSpace(slopes, material, orders, COARSER * resolution)

    def evaluate(
        self, wi: Array, wo: Array, samples: int = 0, rng: np.random.Generator | None = None
    ) -> Evaluation:
        """Evaluate for a unit vector `wi` (3,), z > 0, and unit vectors `wo` (3, n), z either sign.

        `samples` and `rng` are not used. `stderr` is the difference of two resolutions.
        """
        dtype = wi.dtype
        wi, wo = wi.astype(float), wo.astype(float)
        value, unresolved = self.fine.evaluate(wi, wo)
        error = np.abs(value - self.coarse.evaluate(wi, wo)[0])
        return Evaluation(value.astype(dtype), error.astype(dtype), unresolved)

    def energy(self, wi: Array) -> Energy:
        """Energy of each order that leaves, for a unit vector `wi` (3,), z > 0."""
        wi = wi.astype(float)[:, None]
        fine, coarse = (s.energy(wi)[..., 0] for s in (self.fine, self.coarse))
        return Energy(fine, np.zeros_like(fine), np.abs(fine - coarse))
