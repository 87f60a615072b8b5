"""Correlation lengths of heights along the axes of the grid, with error bars."""

import numpy as np

from surfaces.describe.quantities import Quantity
from surfaces.describe.spread import block_means, covariance, stderr
from surfaces.facet import Array
from surfaces.patch import Patch

LEVEL = 1 / np.e
"""Of the autocorrelation, at the correlation length; Sal of ISO 25178-2 has 0.2."""

ROWS = 256
"""Transformed together."""


TERMS = 3
"""Of the plane that levelling takes out, each with the power of one of the longest waves."""


def correlation_lengths(patch: Patch, unit: str) -> list[Quantity]:
    """Where the autocorrelation along x and y has fallen to 1/e, and their geometric mean."""
    along = [_length(patch, axis) for axis in (0, 1)]
    note = "autocorrelation 1/e"
    names = [f"correlation_length{end}" for end in ("", "_x", "_y")]
    notes = [f"{note}; geometric mean of x and y", note, note]
    lengths = np.array([length for length, _, _ in along])
    lengths = np.array([np.sqrt(lengths.prod()), *lengths])
    errors = _errors(lengths, along)
    rows = zip(names, lengths.tolist(), errors.tolist(), notes, strict=True)
    return [Quantity(name, length, error, unit, text) for name, length, error, text in rows]


def _errors(lengths: Array, along: list[tuple[float, Array, float]]) -> Array:
    """Standard errors of the mean length, of that along x and of that along y.

    A length found too short has too short an error, since it goes as the length squared: so does
    the correlation area, by which a patch counts. A deviation of r, relative to the length, over
    such an error has the mean square 1 + 36 r^2, to second order, which the error is made up for.
    What levelling takes out of the longest waves is no noise, and is added.
    """
    shape = np.min([moves.shape for _, moves, _ in along], axis=0)
    blocks = [block_means(moves[: shape[0], : shape[1]]) for _, moves, _ in along]
    x, y = (b / length for b, length in zip(blocks, lengths[1:], strict=True))
    square = np.diag(covariance(np.stack([(x + y) / 2, x, y])))
    taken = np.array([taken / length for length, _, taken in along])
    taken = np.array([taken.mean(), *taken])
    return np.asarray(lengths * np.sqrt(square * (1 + 36 * square) + taken**2))


def _length(patch: Patch, axis: int) -> tuple[float, Array, float]:
    """The length along an axis, what moves it, as means over the patch (nx, ny) do, and by how much
    levelling makes it shorter; not numbers, where heights correlate over more than half of it."""
    h = np.moveaxis(patch.heights - patch.heights.mean(), axis, 0)
    along = autocovariance(h, patch.periodic)
    below = np.flatnonzero(along < LEVEL * along[0])
    if below.size == 0:
        return float("nan"), np.full(patch.heights.shape, np.nan), float("nan")
    lag = int(below[0]) - 1
    fall = along[lag] - along[lag + 1]
    part = (along[lag] - LEVEL * along[0]) / fall
    near, far = (_shifted(h, lag + k, patch.periodic) for k in (0, 1))
    kept = h[: near.shape[0]] if patch.periodic else h[: far.shape[0]]
    near = near[: kept.shape[0]]
    # What moves the place where the two sides of R(l) = R(0) / e are equal.
    scale = patch.step[axis] / float(fall)
    moves = scale * kept * ((1 - part) * near + part * far - LEVEL * kept)
    terms = 1 if patch.periodic else TERMS
    taken = terms * stderr(h) ** 2 * (1 - LEVEL) * scale
    return float((lag + part) * patch.step[axis]), np.moveaxis(moves, 0, axis), float(taken)


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
