"""Orders of scattering in a half space, from the scattering kernel alone.

With heights integrated out, the BSDF F_n(v, o) of order n from a downward direction v of travel
to an upward one o obeys, with c = |cos theta|, sigma' the projected area seen along the upward of
two opposite directions, and products that integrate over intermediate directions,

    F_n (sigma'_v c_o + sigma'_o c_v + c_v c_o) = [n = 1] q_du + c_o q_dd F_(n-1) + c_v F_(n-1) q_uu
                                                 + c_v c_o sum over a + b = n - 1 of F_a q_ud F_b

(invariant embedding: a thin layer is added on top, where c / sigma' is a mean free path by
[HHdD16] Eq. 24). By reciprocity q_uu is q_dd transposed and F is symmetric in v and -o, so both
are labelled by the same nodes. Arrays are (channels, blocks, rows, nodes); blocks do not mix.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from surfaces.facet import Array


@dataclass(frozen=True)
class Kernel:
    """Scattering between `n` nodes, in channels and blocks (Fourier modes, or parities)."""

    cos: Array
    """|cos theta| of the nodes (n,)."""
    sigma: Array
    """Projected area (n,) towards the node, taken upward."""
    weight: Array
    """Solid angles (n,) of the nodes in block 0, the one that carries the energy."""
    down: Array
    """q_dd times the weights of the direction after the facet."""
    across: Array
    """q_du, no weights."""
    turn: Array | None
    """q_ud times the weights of both directions; None where light never turns down again."""


@dataclass(frozen=True)
class Rows:
    """Scattering from further directions (rows), beside the nodes."""

    cos: Array
    """(rows,)"""
    sigma: Array
    down: Array
    across: Array


def path_weight(cos_v: Array, sigma_v: Array, cos_o: Array, sigma_o: Array) -> Array:
    """What F is divided by: c_v c_o (1 + Lambda_v + Lambda_o) ([HHdD16] Eq. 7)."""
    return sigma_v * cos_o + sigma_o * cos_v + cos_v * cos_o


@dataclass(frozen=True)
class Series:
    """Light of each order, from some directions to the nodes."""

    orders: list[Array]
    """F_1 to F_K."""
    rest: Array
    """The sum of all later orders."""
    unresolved: float
    """Energy by which that sum may fall short."""

    @cached_property
    def terms(self) -> list[Array]:
        """F_1 to F_K and the rest."""
        return [*self.orders, self.rest]

    def since(self, n: int) -> Array:
        """The sum of all orders from `n` on, 1 <= n <= K + 1."""
        total: Array = np.sum(self.terms[n - 1 :], axis=0)
        return total


@dataclass(frozen=True)
class Table:
    """All orders of F between the nodes; with it, from and to any direction."""

    kernel: Kernel
    series: Series

    @cached_property
    def turned(self) -> list[Array]:
        """turn @ F for each term; empty where light never turns down again."""
        turn = self.kernel.turn
        return [] if turn is None else [turn @ F for F in self.series.terms]

    def extend(self, rows: Rows) -> Series:
        """All orders from the directions of `rows` to the nodes."""
        k, F, K = self.kernel, self.series.terms, len(self.series.orders)
        c = rows.cos[:, None]
        divisor = path_weight(c, rows.sigma[:, None], k.cos, k.sigma)
        back = np.swapaxes(k.down, -1, -2)
        onward = k.cos / divisor * (rows.down @ np.stack(F))
        X = [rows.across / divisor]
        for n in range(2, K + 1):
            turns = _chain(X[: n - 2], self.turned[: n - 2][::-1])
            X.append(onward[n - 2] + c / divisor * (X[-1] @ back + k.cos * turns))
        turns = _chain(X, _tails(self.turned, K))
        source = onward[K - 1] + onward[K] + c / divisor * (X[-1] @ back + k.cos * turns)
        again = back + k.cos * np.sum(self.turned, axis=0) if self.turned else back
        rest, unresolved = _settle(k, lambda R: source + c / divisor * (R @ again), source)
        return Series(X, rest, unresolved)

    def connect(self, rows: Rows, X: Series, ends: Rows, Y: Series) -> Array:
        """Orders 2 to K and the rest, (K, channels, blocks, n), from one direction (`rows`, and
        the series `X` that starts there) to n others, whose mirror images the light is followed
        back to (`ends`, `Y`)."""
        K = len(X.orders)
        c, turn = rows.cos, self.kernel.turn
        divisor = path_weight(c, rows.sigma, ends.cos, ends.sigma)

        def step(X: Array, Y: Array) -> Array:
            onward = ends.cos * np.sum(rows.down * Y, axis=-1)
            total: Array = onward + c * np.sum(X * ends.down, axis=-1)
            return total

        values = [step(X.orders[n - 2], Y.orders[n - 2]) for n in range(2, K + 1)]
        values.append(step(X.since(K), Y.since(K)))
        if turn is not None:
            X_turned = [term @ turn for term in X.terms]
            for n in range(2, K + 1):
                for a in range(1, n - 1):
                    paths = np.sum(X_turned[a - 1] * Y.orders[n - 2 - a], axis=-1)
                    values[n - 2] += c * ends.cos * paths
            for a in range(1, K + 2):
                paths = np.sum(X_turned[a - 1] * Y.since(max(K - a, 1)), axis=-1)
                values[-1] += c * ends.cos * paths
        return np.stack(values) / divisor


def energy(kernel: Kernel, series: Series) -> Array:
    """Energy (channels, orders + 1, rows) that leaves in each order."""
    flux = kernel.weight * kernel.cos
    return np.stack([F[:, 0] @ flux for F in series.terms], axis=1)


def tabulate(kernel: Kernel, orders: int) -> Table:
    """Solve for F between all nodes."""
    k = kernel
    c, sigma = k.cos[:, None], k.sigma[:, None]
    divisor = path_weight(c, sigma, k.cos, k.sigma)

    def pass_on(F: Array) -> Array:
        onward = k.cos * (k.down @ F)
        total: Array = (onward + np.swapaxes(onward, -1, -2)) / divisor
        return total

    F = [k.across / divisor]
    turned = [] if k.turn is None else [k.turn @ F[0]]
    between = c * k.cos / divisor
    for n in range(2, orders + 1):
        F.append(pass_on(F[-1]) + between * _chain(F[: n - 2], turned[: n - 2][::-1]))
        if k.turn is not None:
            turned.append(k.turn @ F[-1])
    source = pass_on(F[-1]) + between * _chain(F, _tails(turned, orders))
    first, first_turned = np.sum(F, axis=0), np.sum(turned, axis=0)

    def step(R: Array) -> Array:
        total = source + pass_on(R)
        if k.turn is not None:
            R_turned = k.turn @ R
            total += between * (R @ (first_turned + R_turned) + first @ R_turned)
        return total

    return Table(kernel, Series(F, *_settle(k, step, source)))


def _chain(X: list[Array], turned: list[Array]) -> Array | float:
    """The sum of X_a turn F_b over paired lists; 0 where light never turns down again."""
    return sum((a @ b for a, b in zip(X, turned, strict=False)), 0.0)


def _tails(turned: list[Array], K: int) -> list[Array]:
    """For a = 1 to K, the sum of all turned orders b with a + b >= K."""
    return [np.sum(turned[max(K - a, 1) - 1 :], axis=0) for a in range(1, K + 1)] if turned else []


MOST_ORDERS = 100_000
"""Light that takes so many orders to fade is not followed: thirty times those of roughness 100."""


def _settle(kernel: Kernel, step: Callable[[Array], Array], start: Array) -> tuple[Array, float]:
    """Iterate until the energy no longer grows, beyond rounding; what may still be missing.

    Energies only grow, as every iteration adds paths, and block 0 bounds the others, whose
    kernels are that of block 0 with signs.
    """
    flux = kernel.weight * kernel.cos
    rounding = np.finfo(float).eps * np.sqrt(kernel.cos.size)
    R, level, growth = start, start[:, 0] @ flux, np.inf
    while True:
        R = step(R)
        previous, level = level, R[:, 0] @ flux
        before, growth = growth, np.max(np.abs(level - previous))
        # Nothing but a grid that is too coarse makes more light than has come in.
        if not np.max(np.abs(level)) < 2:
            raise ArithmeticError(
                "method solve is too coarse for this: energy grows from order to order; walk is "
                "the method to take"
            )
        enough = rounding * np.max(np.abs(level))
        if growth <= enough:
            # What is missing falls off like a geometric series.
            return R, float(growth * growth / (before - growth)) if growth < before else growth
        if growth < before < np.inf and np.log(enough / growth) < MOST_ORDERS * np.log(
            growth / before
        ):
            raise ArithmeticError(
                "method solve would have to follow light to hundreds of thousands of facets, as "
                "surfaces so steep hold it fast; with a bound on facets, walk is the method to take"
            )


class Discretisation(ABC):
    """Directions as nodes and blocks, and the scattering kernel between them."""

    @abstractmethod
    def kernel(self) -> Kernel:
        """Scattering between the nodes."""

    @abstractmethod
    def rows(self, d: Array) -> Rows:
        """Scattering from directions (3, rows) to the nodes; the sign of z is of no account."""

    @abstractmethod
    def distinct(self, d: Array) -> tuple[Array, Array]:
        """Directions (3, m) for which to make rows, and which of them serves each of `d`."""

    def first_order(self, wi: Array) -> Array | None:
        """Its energy (channels,) for `wi` (3,), where that is better known than from the rows."""
        return None

    @abstractmethod
    def parting(self, a: Array, b: Array) -> Array:
        """Factors (blocks, n) that sum blocks to values from `a` (3, 1) to `b` (3, n)."""
