"""Functions of a normal number, tabulated: a look-up costs a tenth of the function.

Of the node that is next; beyond `WIDEST` they are what they are there, where either nothing crosses
a ray or the surface is above it for certain.
"""

import numpy as np
from scipy.special import erfc, log_ndtr, ndtri

from surfaces.facet import Array

ROOT_2 = float(np.sqrt(2))
ROOT_2_PI = float(np.sqrt(2 * np.pi))

WIDEST = 9.0
NODES = 1 << 14


def node(x: Array) -> Array:
    """The node next to `x` (n,)."""
    scale = (NODES - 1) / (2 * WIDEST)
    return ((np.clip(x, -WIDEST, WIDEST) + WIDEST) * scale + 0.5).astype(np.intp)


def excess(k: Array) -> Array:
    """phi(k) - k Phi(-k), the mean of what a normal number has above k."""
    # Of a vertical ray the square is infinite, which is right there.
    with np.errstate(over="ignore"):
        peak = np.exp(k * k * -0.5) * (1 / ROOT_2_PI)
    return peak - k * erfc(k * (1 / ROOT_2)) * 0.5


def depth(h: Array) -> Array:
    """t = -ln C1(h), the coordinate in which Smith's free paths are exponential."""
    return -log_ndtr(h)


def height(t: Array) -> Array:
    """The height of a depth, with all digits at both ends."""
    t = np.maximum(t, np.finfo(t.dtype).tiny)
    return np.where(t < np.log(2), -ndtri(-np.expm1(-t)), ndtri(np.exp(-t)))


def _truncated(b: Array) -> tuple[Array, Array]:
    """-E[y] and 1 - var(y) of a normal number y, given that it is below b."""
    mean = np.exp(-b * b / 2 - log_ndtr(b)) / ROOT_2_PI
    return mean, np.clip(mean * (mean + b), 0, 1)


def _crossing(k: Array) -> tuple[Array, Array]:
    """Mean and variance of y, of density proportional to (y - k)+ times the normal one."""
    x, weight = np.polynomial.legendre.leggauss(80)
    mean, square = np.empty((2, k.size))
    for i, low in enumerate(k):
        # What y has above k: 9 deviations, and less where it falls off as exp(-k z).
        z = (x + 1) / 2 * min(9 - min(low, 0), 9 if low < 1 else 30 / low)
        f = weight * z * np.exp(-z * (z / 2 + low) - min(low, 0) ** 2 / 2)
        mean[i], square[i] = (f @ z**n / f.sum() for n in (1, 2))
    return k + mean, square - mean**2


_X = np.linspace(-WIDEST, WIDEST, NODES)
LOG_BELOW, LESS = (f(_X).astype(np.float32) for f in (log_ndtr, lambda x: excess(-x)))
TRUNCATED, NARROWER = (a.astype(np.float32) for a in _truncated(_X))
_K = np.linspace(-WIDEST, WIDEST, 256)
CROSSING, SCATTER = (np.interp(_X, _K, a).astype(np.float32) for a in _crossing(_K))
"""ln Phi; E[(x - y)+]; what lies below x: minus its mean, and 1 less its variance; what
crosses at x: its mean and its variance."""
