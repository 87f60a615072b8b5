"""Means and standard errors, order by order, of estimates that come in batches of walks."""

from collections.abc import Iterator

import numpy as np

from msbsdf_cli.smith.walk import BLOCK
from surfaces.facet import Array

BATCH = 4 * BLOCK
"""Walks followed together: enough that few are left to walk alone after the early orders."""

BATCH_VALUES = 1 << 20
"""At most so many values, walks times directions, belong to a batch, however many samples."""


def batches(samples: int, directions: int) -> Iterator[int]:
    """Sizes of the batches that `samples` walks are followed in; memory is that of one batch."""
    size = min(BATCH, max(1, BATCH_VALUES // max(directions, 1)))
    for start in range(0, samples, size):
        yield min(size, samples - start)


class Estimate:
    """Sums over walks of what each adds to each order, and of its square.

    A walk adds once to an order up to the last reported one. To the sum of the later orders it
    may add any number of times; these are gathered walk by walk before they are squared.

    Walks from one side add to all directions: values are (channels, lanes, directions). Walks
    that each start from a direction of their own add to that one only: values are
    (channels, lanes, 1), and `starts` (lanes,) names the direction.
    """

    def __init__(self, channels: int, orders: int, directions: int) -> None:
        self.orders = orders
        self.sums = np.zeros((channels, orders + 1, directions))
        self.squares = np.zeros_like(self.sums)
        self.tail: Array | None = None
        self.tail_starts: Array | None = None

    def open_tail(self, walks: int, directions: int, starts: Array | None = None) -> None:
        """Make room for the walks of a batch that go beyond the last reported order."""
        self.tail = np.zeros((self.sums.shape[0], walks, directions))
        self.tail_starts = starts

    def add(self, order: int, value: Array, slots: Array, starts: Array | None = None) -> None:
        """What walks add to `order`; `slots` (lanes,) numbers them within an open tail."""
        if order <= self.orders:
            self._add_row(order - 1, value, starts)
        elif self.tail is not None:
            self.tail[:, slots] += value

    def close_batch(self) -> None:
        """Nothing more comes from the walks of this batch."""
        if self.tail is not None:
            self._add_row(self.orders, self.tail, self.tail_starts)
            self.tail = None

    def mean(self, walks: int) -> tuple[Array, Array]:
        """Mean of `walks` walks and its standard error, (channels, orders + 1, directions)."""
        mean = self.sums / walks
        if walks == 1:
            return mean, np.where(mean == 0, 0, np.inf)
        return mean, np.sqrt(np.maximum(self.squares / walks - mean * mean, 0) / (walks - 1))

    def _add_row(self, row: int, value: Array, starts: Array | None) -> None:
        if starts is None:
            self.sums[:, row] += value.sum(axis=1, dtype=float)
            self.squares[:, row] += np.einsum("cln,cln->cn", value, value, dtype=float)
            return
        n = self.sums.shape[2]
        for channel, one in enumerate(value[:, :, 0]):
            self.sums[channel, row] += np.bincount(starts, one, n)
            self.squares[channel, row] += np.bincount(starts, one * one, n)
