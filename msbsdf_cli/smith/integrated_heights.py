"""Heights integrated out: the probability that a path of given directions meets all its facets.

For the directions d_0 ... d_b of a path, let H(a..b) be the probability that light that arrives
from above along d_a, a downward one, meets a facet, leaves it along d_(a+1), meets the next one,
and so on, and leaves the surface for good along d_b, an upward one. With the extinction
L = sigma(d) / |d_z| it is

    H(a..b) = ( [d_(a+1) down] L_a H(a+1..b) + [d_(b-1) up] L_(b-1) H(a..b-1)
                + sum over k of L_(k-1) H(a..k-1) H(k..b) ) / (L_a + L_b)

where the sum is over the k with d_(k-1) upward and d_k downward, and neighbours have
H = L_a / (L_a + L_b). It follows from the heights' exponential laws in t = -ln C1 (integrate over
the topmost vertex); every term is positive, so that no digits are lost. The Laplace transforms of
Bitterli & d'Eon 2022 (A Position-Free Path Integral for Homogeneous Slabs and Multiple Scattering
on Smith Microfacets) and Cui et al. 2023 describe the same integral by differences.
"""

from dataclasses import dataclass

import numpy as np

from surfaces.facet import Array


def extinction_of(d: Array, sigma: Array) -> Array:
    """The extinction sigma(d) / |d_z|, (n,): Lambda(d) for an upward direction, 1 + Lambda(-d) for
    a downward one; finite also where d is closer to the horizon than rounding can tell."""
    return sigma / np.maximum(np.abs(d[2]), np.finfo(d.dtype).eps ** 2)


@dataclass
class IntegratedHeights:
    """What H needs to know of n paths that each go down p times so far."""

    extinction: Array
    """Of the downward directions, (p, n)."""
    follow: Array
    """The same, but 0 where the direction after is upward, (p, n)."""
    up: Array
    """L_(b-1) H(a..b-1) for each downward a, if the last direction d_(b-1) is upward, (p, n)."""
    turn: Array | None = None
    """(p, p, n): the same at [k, a] for the upward direction just before the k-th downward one.
    None where light that goes up never goes down again."""

    def leaving(self, x: Array) -> list[Array]:
        """H(a..b) for each downward a, p arrays (n, m), if the paths go on along an upward
        direction of L_b = `x`, (m,) or (n, 1); for x = 0 the probability to have come so far."""
        H: list[Array] = []
        below = np.ones((1, 1), self.extinction.dtype)
        p = len(self.extinction)
        for a in reversed(range(p)):
            numerator = self.follow[a][:, None] * below + self.up[a][:, None]
            if self.turn is not None:
                for k in range(a + 1, p):
                    numerator += self.turn[k, a][:, None] * H[p - 1 - k]
            below = numerator / (self.extinction[a][:, None] + x)
            H.append(below)
        return H[::-1]

    def upward(self, extinction: Array) -> "IntegratedHeights":
        """The paths after one more direction, an upward one, of the given extinction (n,)."""
        up = np.stack([extinction * H[:, 0] for H in self.leaving(extinction[:, None])])
        follow = self.follow.copy()
        follow[-1] = 0
        return IntegratedHeights(self.extinction, follow, up, self.turn)

    def downward(self, extinction: Array) -> "IntegratedHeights":
        """The paths after one more direction, a downward one, of the given extinction (n,)."""
        p = len(self.extinction)
        turn = self.turn
        if turn is not None:
            turn = np.zeros((p + 1, p + 1, extinction.size), extinction.dtype)
            turn[:p, :p] = self.turn
            turn[p, :p] = self.up
        last = extinction[None]
        up = np.zeros((p + 1, extinction.size), extinction.dtype)
        return IntegratedHeights(
            np.concatenate([self.extinction, last]), np.concatenate([self.follow, last]), up, turn
        )


def arriving_heights(extinction: Array, turns: bool) -> IntegratedHeights:
    """Paths that arrive from above along a direction of the given extinction (n,)."""
    turn = np.zeros((1, 1, extinction.size), extinction.dtype) if turns else None
    return IntegratedHeights(
        extinction[None], extinction[None], np.zeros((1, extinction.size), extinction.dtype), turn
    )
