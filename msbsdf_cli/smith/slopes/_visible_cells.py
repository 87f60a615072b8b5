"""Slopes of facets that a direction sees, where these are counted in cells.

A direction (s, z, phi) sees (z - s X)+ of a facet of slope X along its azimuth. Rejection samples
that exactly: a cell is proposed with a bound of what any direction in a bin of directions sees of
it, a place in it is drawn, and it is accepted by what is really seen of it.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from surfaces.facet import Array

POLAR_BINS, AZIMUTH_BINS = 32, 64
"""Bins of directions, each with the probabilities of all cells. With fewer, more is rejected; with
more, the tables leave the cache."""

MOST_ROUNDS = 500
"""After which what is left sees nothing but the edge of the steepest cell, if that."""


@dataclass(frozen=True)
class VisibleCells:
    """Tables for drawing cells (A. J. Walker, An efficient method for generating discrete random
    variables with general distributions, ACM TOMS 3, 1977), a row for each bin."""

    low: Array
    size: Array
    """Lower corners and sizes of the cells, (2, cells)."""
    keep: Array
    """Probability of keeping a cell that was drawn, (bins, cells)."""
    other: Array
    """The cell that takes its place."""
    bound: Array
    """Bound of what is seen of it."""

    @classmethod
    def of(cls, share: Array, low: Array, size: Array) -> "VisibleCells":
        """For cells of shares (n,), lower corners and sizes (2, n)."""
        bound = _bounds(low, size)
        keep, other = _aliases(bound * share)
        return cls(low, size, keep, other, bound.astype(np.float32))

    def slopes(
        self, s: Array, z: Array, phi: Array, rng: np.random.Generator
    ) -> tuple[Array, Array]:
        """Slopes x and y (n,), one for each direction."""
        length = np.sqrt(s * s + z * z)
        s, z = s / length, z / length
        cos, sin = s * np.cos(phi), s * np.sin(phi)
        polar = np.arctan2(z, s) * (POLAR_BINS / np.pi) + POLAR_BINS / 2
        azimuth = phi * (AZIMUTH_BINS / (2 * np.pi)) + AZIMUTH_BINS / 2
        bins = np.minimum(polar.astype(np.intp), POLAR_BINS - 1) * AZIMUTH_BINS
        bins += np.minimum(azimuth.astype(np.intp), AZIMUTH_BINS - 1)
        x, y = np.empty((2, s.size))
        lanes, cells = np.arange(s.size), self.low.shape[1]
        for _ in range(MOST_ROUNDS):
            u = rng.random((4, lanes.size))
            drawn = u[0] * cells
            cell = drawn.astype(np.intp)
            row = bins * cells
            at = row + cell
            cell = np.where(drawn - cell < self.keep.take(at), cell, self.other.take(at))
            a = self.low[0].take(cell) + self.size[0].take(cell) * u[1]
            b = self.low[1].take(cell) + self.size[1].take(cell) * u[2]
            seen = z - cos * a - sin * b
            accepted = u[3] * self.bound.take(row + cell) < seen
            done = lanes.compress(accepted)
            x[done], y[done] = a.compress(accepted), b.compress(accepted)
            left = ~accepted
            lanes, bins = lanes.compress(left), bins.compress(left)
            if lanes.size == 0:
                return x, y
            z, cos, sin = z.compress(left), cos.compress(left), sin.compress(left)
        x[lanes], y[lanes] = self._most_visible(z, cos, sin)
        return x, y

    def _most_visible(self, z: Array, cos: Array, sin: Array) -> tuple[Array, Array]:
        """The slopes of which directions see most."""
        corners = _corners(self.low, self.size)
        best = [np.argmax(-c * corners[0] - s * corners[1]) for c, s in zip(cos, sin, strict=True)]
        return corners[0, best], corners[1, best]


def _corners(low: Array, size: Array) -> Array:
    """Corners (2, 4 n) of cells."""
    parts = [low + size * np.array([[p], [q]]) for p in (0, 1) for q in (0, 1)]
    return np.concatenate(parts, axis=1)


def _bounds(low: Array, size: Array) -> Array:
    """Of what is seen of the cells (bins, n) from anywhere in a bin.

    What is seen of a slope is the product of the unit direction with (-x, -y, 1). In the angles its
    second derivatives are at most the length of the latter, so that between the corners of a bin
    it is above what they say by at most that times an eighth of the squares of the bin's sides.
    """
    psi = np.pi * (np.arange(POLAR_BINS + 1) / POLAR_BINS - 0.5)
    phi = 2 * np.pi * (np.arange(AZIMUTH_BINS + 1) / AZIMUTH_BINS - 0.5)
    corners = _corners(low, size)
    along = np.cos(phi)[:, None] * corners[0] + np.sin(phi)[:, None] * corners[1]
    along = along.reshape(AZIMUTH_BINS + 1, 4, -1).min(axis=1)
    along = np.minimum(along[:-1], along[1:])
    ends = [np.sin(p) - np.cos(p) * along for p in psi]
    most = np.stack([np.maximum(a, b) for a, b in pairwise(ends)])
    far = np.sqrt(1 + (corners**2).sum(axis=0)).reshape(4, -1).max(axis=0)
    between = ((np.pi / POLAR_BINS) ** 2 + (2 * np.pi / AZIMUTH_BINS) ** 2) / 8
    return np.maximum(most + between * far, 0).reshape(POLAR_BINS * AZIMUTH_BINS, -1)


def _aliases(weights: Array) -> tuple[Array, Array]:
    """Walker's tables (bins, n) for weights, all bins at once.

    Cells are paired one by one: the lightest with the heaviest that has something to give. Rows
    without weight draw all cells alike.
    """
    bins, n = weights.shape
    total = weights.sum(axis=1, keepdims=True)
    left = np.where(total > 0, weights * n / np.where(total > 0, total, 1), 1.0)
    keep, other = np.ones(bins * n, np.float32), np.tile(np.arange(n, dtype=np.int16), bins)
    # Cells are numbered through all bins: places in flat tables are found several times as fast.
    rows = np.arange(0, bins * n, n)
    order = (np.argsort(left, axis=1) + rows[:, None]).ravel()
    left = left.ravel()
    small, large = rows.copy(), rows + n - 1
    cell = order.take(small)
    for _ in range(n - 1):
        giver = order.take(large)
        mine = left.take(cell)
        keep[cell], other[cell] = mine, giver - rows
        rest = left.take(giver) - (1 - mine)
        left[giver] = rest
        # A giver that fell below one is next to be filled up.
        fell = rest < 1
        large -= fell
        small += ~fell
        cell = np.where(fell, giver, order.take(small))
    keep[cell] = 1
    return keep.reshape(bins, n), other.reshape(bins, n)
