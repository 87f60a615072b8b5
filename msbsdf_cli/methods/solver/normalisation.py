"""A discrete kernel that scatters exactly what arrives.

The integral of q(d -> w) over all w is sigma(d), but for albedo ([HHdD16] Eq. 40). As
discrete-ordinates codes do, the kernel is scaled until its quadrature says the same; otherwise a
coarse grid on a rough surface gains energy at each order. The scale belongs to a direction and
stands on both sides of the kernel, so that reciprocity is kept.
"""

from dataclasses import dataclass

import numpy as np

from surfaces.facet import Array


@dataclass(frozen=True)
class KernelScale:
    """Scales of the nodes' directions, upward and downward ones seen from either side."""

    front: Array
    """(n,) for light that comes from above or leaves to it."""
    behind: Array
    """(n,) for light that comes from below or leaves to it."""
    weight: Array
    """Solid angles (n,)."""

    def rows(self, across: Array, down: Array, sigma: Array) -> Array:
        """Scales (rows,) for rows from elsewhere: q to upward and to downward nodes in block 0,
        (rows, n), without albedo."""
        total = across @ (self.front * self.weight) + down @ (self.behind * self.weight)
        return _ratio(sigma, total)


def balance(
    across: Array, down: Array, turn: Array, weight: Array, sigma: Array, sigma_up: Array
) -> KernelScale:
    """Scales for kernels (n, n) in block 0: from front to front, to behind, and behind to behind.

    `sigma` (n,) are the projected areas towards downward directions, `sigma_up` towards upward
    ones. Symmetric scaling by the square root of what is wrong (Sinkhorn & Knopp 1967).
    """
    n = weight.size
    q = np.block([[across, down], [down.T, turn]]) * np.tile(weight, 2)
    wanted = np.concatenate([sigma, sigma_up])
    scale, error = np.ones(2 * n), np.inf
    while True:
        correction = np.sqrt(_ratio(wanted, scale * (q @ scale)))
        scale = scale * correction
        previous, error = error, np.max(np.abs(correction - 1))
        # It converges by a constant factor, down to rounding.
        if not error < previous:
            return KernelScale(scale[:n], scale[n:], weight)


def _ratio(wanted: Array, found: Array) -> Array:
    """Where no facet is seen there is nothing to scale."""
    return np.divide(wanted, found, out=np.ones_like(wanted), where=(wanted > 0) & (found > 0))
