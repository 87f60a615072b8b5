"""Correlation lengths of heights along the axes of the grid, with error bars."""

import numpy as np

from surfaces.describe.quantities import Quantity
from surfaces.describe.spread import stderr
from surfaces.facet import Array
from surfaces.patch import Patch

LEVEL = 1 / np.e
"""Of the autocorrelation, at the correlation length; Sal of ISO 25178-2 has 0.2."""

ROWS = 256
"""Transformed together."""


def correlation_lengths(patch: Patch, unit: str) -> list[Quantity]:
    """Where the autocorrelation along x and y has fallen to 1/e, and their geometric mean."""
    rows = [_length(patch, axis) for axis in (0, 1)]
    found = [
        Quantity(f"correlation_length_{name}", *row, unit, "autocorrelation 1/e")
        for name, row in zip("xy", rows, strict=True)
    ]
    mean = float(np.sqrt(rows[0][0] * rows[1][0]))
    # Both come from the same bumps: their errors are taken to be common.
    relative = sum(error / value for value, error in rows) / 2
    note = "autocorrelation 1/e; geometric mean of x and y"
    return [Quantity("correlation_length", mean, mean * relative, unit, note), *found]


def _length(patch: Patch, axis: int) -> tuple[float, float]:
    h = np.moveaxis(patch.heights - patch.heights.mean(), axis, 0)
    along = autocovariance(h, patch.periodic)
    below = np.flatnonzero(along < LEVEL * along[0])
    if below.size == 0:
        return float("nan"), float("nan")
    lag = int(below[0]) - 1
    fall = along[lag] - along[lag + 1]
    part = (along[lag] - LEVEL * along[0]) / fall
    near, far = (_shifted(h, lag + k, patch.periodic) for k in (0, 1))
    kept = h[: near.shape[0]] if patch.periodic else h[: far.shape[0]]
    near = near[: kept.shape[0]]
    # What moves the place where the two sides of R(l) = R(0) / e are equal.
    moves = kept * ((1 - part) * near + part * far - LEVEL * kept)
    step = patch.step[axis]
    return float((lag + part) * step), stderr(moves) / float(fall) * step


def _shifted(h: Array, lag: int, periodic: bool) -> Array:
    return np.roll(h, -lag, axis=0) if periodic else h[lag:]


def autocovariance(h: Array, periodic: bool) -> Array:
    """Mean products (lags,) of heights (n, m) so many points apart along the first axis, up to half
    of its length."""
    n, m = h.shape
    size = n if periodic else 2 * n
    power = np.zeros(size // 2 + 1)
    for start in range(0, m, ROWS):
        power += (np.abs(np.fft.rfft(h[:, start : start + ROWS], size, axis=0)) ** 2).sum(axis=1)
    lags = np.arange(n // 2 + 1)
    pairs = n if periodic else n - lags
    return np.asarray(np.fft.irfft(power, size)[lags] / (pairs * m))
