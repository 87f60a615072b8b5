"""How far the mean over a patch may be off: from the patch itself, without cutting it up.

Heights that are near each other are alike, so that a mean has the noise of as many numbers as there
are correlation areas. Its variance is the power of the averaged quantity at wave number zero; the
mean itself hides that, but the power at the next wave numbers is nearly the same as long as their
waves are long against what correlates, and is there to be seen (P. Heidelberger & P. D. Welch, A
spectral method for confidence interval generation, Communications of the ACM 24, 1981).
"""

import numpy as np

from surfaces.facet import Array

BLOCKS = 32
"""Along either axis, into which a quantity is summed up before its longest waves are looked at."""

WAVES = 2
"""Longest waves along either axis, both ways: 24 numbers, which tell a standard error to 15 %."""


def block_means(values: Array) -> Array:
    """Means (..., b, b) of a quantity (..., nx, ny) over blocks, b at most `BLOCKS`.

    What is left over at the far sides is left out: it is less than a block.
    """
    for axis in (-2, -1):
        n = values.shape[axis]
        size = -(-n // BLOCKS)
        kept = values.take(range(n // size * size), axis) if n % size else values
        shape = list(values.shape)
        shape[axis : axis + 1 or None] = [n // size, size]
        values = kept.reshape(shape).mean(axis=axis)
    return values


def covariance(blocks: Array) -> Array:
    """Covariance (m, m) of the means over the patch of quantities, from their `block_means`
    (m, bx, by)."""
    m, bx, by = blocks.shape
    waves = np.fft.fft2(blocks)
    kx, ky = (np.flatnonzero(np.minimum(np.arange(b), b - np.arange(b)) <= WAVES) for b in (bx, by))
    longest = waves[:, kx[:, None], ky].reshape(m, -1)[:, 1:] / (bx * by)
    return np.asarray((longest @ longest.conj().T).real / longest.shape[1])


def stderr(values: Array) -> float:
    """Standard error of the mean of a quantity (nx, ny) over a patch."""
    return float(np.sqrt(covariance(block_means(values)[None])[0, 0]))
