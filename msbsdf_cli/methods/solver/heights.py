"""Free paths between heights, on Gauss nodes from the bottom of the microsurface to its top.

Heights are written as C1, the share of the surface that lies lower ([HHdD16] Section 3.1), or as
t = -ln C1, in which a free path is exponential. Seen from the other side C1 is 1 - C1, and the
nodes are symmetric, so that the change of sides reverses their order.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.solver.nodes import gauss, interpolation
from surfaces.facet import Array

CROWDING = 3
"""C1 = y^3 / (y^3 + (1 - y)^3) with y a Gauss node: grazing light sees only the very top, on
either side, and steep light has weak logarithms at the very bottom."""

PATHS = 2
"""Nodes of an integral over a free path, for each node of the heights."""


@dataclass(frozen=True)
class Heights:
    """`n` heights and what lies between them."""

    n: int

    @cached_property
    def t(self) -> Array:
        """-ln C1 at the nodes (n,)."""
        y, _ = gauss(self.n)
        t: Array = np.log1p(((1 - y) / y) ** CROWDING)
        return t

    def escape(self, Lambda: Array) -> Array:
        """Chance (..., n) of leaving from each height in upward directions ([HHdD16] Eq. 1)."""
        chance: Array = np.exp(-np.multiply.outer(Lambda, self.t))
        return chance

    def arrive(self, L: Array) -> Array:
        """Weights (..., n) of the heights of the first facet, for light from outside of
        extinction L = sigma / cos (...): the mean of a function of height over these."""
        E, weight = self._exponential
        return np.einsum("k,...kn->...n", weight, self._at(E / L[..., None]))

    def sink(self, L: Array) -> Array:
        """Matrices (m, n, n): the next facet's height, from each height, downward (L >= 1)."""
        E, weight = self._exponential
        t = self.t[:, None] + E / L[:, None, None]
        return np.einsum("k,mikj->mij", weight, self._at(t))

    def rise(self, Lambda: Array) -> Array:
        """Matrices (m, n, n): the next facet's height, from each height, upward; rows sum to the
        probability of not leaving."""
        u, weight = gauss(PATHS * self.n)
        meets = -np.expm1(-np.multiply.outer(Lambda, self.t))
        with np.errstate(divide="ignore", invalid="ignore"):
            path = -np.log1p(-u * meets[..., None]) / Lambda[:, None, None]
        # Towards the normal nothing is met, and along the way every height is as likely.
        path = np.where(Lambda[:, None, None] > 0, path, u * self.t[:, None])
        t = np.maximum(self.t[:, None] - path, 0)
        return np.einsum("k,mikj->mij", weight, self._at(t)) * meets[..., None]

    @cached_property
    def _exponential(self) -> tuple[Array, Array]:
        """Nodes and weights of an expectation over an exponential number E = -ln s^3."""
        s, ds = gauss(PATHS * self.n)
        return -3 * np.log(s), 3 * s * s * ds

    def _at(self, t: Array) -> Array:
        """Interpolation (..., n) to heights t."""
        ratio = np.expm1(t) ** (1 / CROWDING)
        return interpolation(self.n, 1 / (1 + ratio))
