"""Free paths between heights, on Gauss nodes from the bottom of the microsurface to its top.

Heights are written as C1, the share of the surface that lies lower ([HHdD16] Section 3.1), or as
t = -ln C1, in which a free path is exponential. Seen from the other side C1 is 1 - C1, and the
nodes are symmetric, so that the change of sides reverses their order.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from msbsdf_cli.methods.solver.nodes import interpolation
from surfaces.facet import Array
from surfaces.quadrature import gauss

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
        return _height(gauss(self.n)[0])

    def escape(self, Lambda: Array) -> Array:
        """Probability (..., n) of leaving each height in upward directions ([HHdD16] Eq. 1)."""
        probability: Array = np.exp(-np.multiply.outer(Lambda, self.t))
        return probability

    def arrive(self, L: Array) -> Array:
        """Weights (..., n) of the heights of the first facet, for light from outside of
        extinction L = sigma / cos (...): the mean of a function of height over these."""
        E, _, weight = self._chance
        return np.einsum("k,...kn->...n", weight, self._at(E / L[..., None]))

    def sink(self, L: Array) -> Array:
        """Matrices (m, n, n): where the next facet lies, from each height, downward (L >= 1), per
        unit of extinction: its probability over L."""
        E, _, weight = self._chance
        t = self.t[:, None] + E / L[:, None, None]
        return np.einsum("k,mikj->mij", weight, self._at(t)) / L[:, None, None]

    def rise(self, Lambda: Array) -> Array:
        """Matrices (m, n, n): the same upward; rows sum to the probability not to leave, over
        Lambda, which towards the normal tends to the length of the way."""
        _, u, weight = self._chance
        meets = -np.expm1(-np.multiply.outer(Lambda, self.t))
        some = Lambda > 0
        length = np.where(some[:, None], meets / np.where(some, Lambda, 1)[:, None], self.t)
        way = -np.log1p(-u * meets[..., None]) / np.where(some, Lambda, 1)[:, None, None]
        # Towards the normal nothing is met, and along the way every height is as likely.
        way = np.where(some[:, None, None], way, u * self.t[:, None])
        t = np.maximum(self.t[:, None] - way, 0)
        return np.einsum("k,mikj->mij", weight, self._at(t)) * length[..., None]

    @cached_property
    def _chance(self) -> tuple[Array, Array, Array]:
        """Nodes and weights of an expectation over an exponential number E, and u = 1 - exp(-E).

        A path ends at the top, or begins there, where heights are cube roots of probabilities:
        these are crowded at either end as heights are."""
        y, dy = gauss(PATHS * self.n)
        one, other = y**CROWDING, (1 - y) ** CROWDING
        weight = dy * (y * (1 - y)) ** (CROWDING - 1) / (one + other) ** 2
        return _height(y), other / (one + other), weight / weight.sum()

    def _at(self, t: Array) -> Array:
        """Interpolation (..., n) to heights t."""
        ratio = np.expm1(t) ** (1 / CROWDING)
        return interpolation(self.n, 1 / (1 + ratio))


def _height(y: Array) -> Array:
    """-ln C1 at places y between the bottom and the top."""
    t: Array = np.log1p(((1 - y) / y) ** CROWDING)
    return t
