"""Distances of a modelled histogram from a simulated one, and what of them is not noise.

Noise alone makes any two histograms differ, and no function of a noisy difference has the size of
the true one for its mean. `unfolded` comes as near as can be: T. T. Cai and M. G. Low, Testing
composite hypotheses, Hermite polynomials and optimal estimation of a nonsmooth functional, Annals
of Statistics 39, 2011, on the same question.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog
from scipy.special import erf

from msbsdf_cli.statistics.jackknife import jackknife
from surfaces.facet import Array
from surfaces.streams import stream

NOISE_DRAWS = 200
"""Enough that the mean and spread of distances by noise are known to some percent."""


class Histogram(NamedTuple):
    """Bins and their standard errors, (bins,) each."""

    value: Array
    stderr: Array


@dataclass(frozen=True)
class Distance:
    """A distance between two histograms of normal noise."""

    found: float
    noise: float
    """Its mean if there were noise alone."""
    own: float
    """What the distance would be without noise; below 0 only by the noise of this estimate."""
    own_stderr: float
    """Of `own`: the scatter of the estimate, and the bias that it may have left."""


def total_variation(
    modelled: Histogram, simulated: Histogram, groups: Array | None = None
) -> Distance:
    """Half the sum of the sizes of the differences of bins.

    The size of each bin is estimated by itself, so that a few large differences are not taken for
    less because of many small ones. `groups` (groups, bins) are histograms of independent parts of
    the simulation, whose mean is the simulated one: bins of one surface are not independent, and
    the jackknife over the parts knows it. Without them they are taken for independent.
    """
    difference, stderr = (
        modelled.value - simulated.value,
        np.hypot(modelled.stderr, simulated.stderr),
    )
    if not np.isfinite(stderr).all():
        return _unknown(_half_sum(difference[None]))
    bias, scatter = leftover()
    model, surfaces = (scatter * np.sqrt((h.stderr**2).sum()) / 2 for h in (modelled, simulated))
    if groups is not None:
        left_out = (groups.sum(axis=0) - groups) / (len(groups) - 1)
        surfaces = jackknife(np.array([_own(modelled.value - h, stderr) for h in left_out]))
    left = np.array([model, surfaces, bias * stderr.sum() / 2])
    return Distance(
        float(_half_sum(difference[None])[0]),
        _of_noise(_half_sum, stderr)[0],
        _own(difference, stderr),
        float(np.sqrt((left**2).sum())),
    )


def _own(difference: Array, stderr: Array) -> float:
    """Half the sum of the sizes without noise."""
    noisy, size = stderr > 0, np.abs(difference)
    reach = stderr[noisy]
    return float(size[~noisy].sum() + (reach * unfolded(size[noisy] / reach)).sum()) / 2


def kolmogorov_smirnov(modelled: Histogram, simulated: Histogram) -> Distance:
    """The largest size of the running sums of the differences of bins.

    It is a single sum, the one that is largest, and its noise at most that of the largest ones.
    """
    found = _largest_sum((modelled.value - simulated.value)[None])
    stderr = np.hypot(modelled.stderr, simulated.stderr)
    if not np.isfinite(stderr).all():
        return _unknown(found)
    noise, spread = _of_noise(_largest_sum, stderr)
    square = noise**2 + spread**2
    return Distance(
        float(found[0]), noise, float(np.sqrt(max(found[0] ** 2 - square, 0))), square**0.5
    )


def _unknown(found: Array) -> Distance:
    """A distance (1,) of histograms whose noise nobody knows, as of a single sample."""
    return Distance(float(found[0]), np.inf, float(found[0]), np.inf)


def _half_sum(difference: Array) -> Array:
    return np.abs(difference).reshape(len(difference), -1).sum(axis=1) / 2


def _largest_sum(difference: Array) -> Array:
    return np.abs(np.cumsum(difference, axis=1)).max(axis=1)


def _of_noise(measure: Callable[[Array], Array], stderr: Array) -> tuple[float, float]:
    """Mean and standard deviation of a distance of noise alone, independent between bins."""
    rng = stream(0, "noise of distances")
    values = measure(stderr * rng.standard_normal((NOISE_DRAWS, *stderr.shape)))
    return float(values.mean()), float(values.std(ddof=1))


STEP = 0.05
REACH = 4.0
"""Noise folds a size to another one up to here, in standard deviations: beyond it by 1e-5."""
STEEPEST = 2.0
"""Slope of `unfolded`. The bias falls with it slowly, from .18 at 2 to .13 at 4, the scatter rises
from 1.5 to 2."""


def unfolded(y: Array) -> Array:
    """Estimates of |mu| from sizes |mu + noise| (n,) of normal noise of standard deviation 1.

    Of all functions no steeper than `STEEPEST`, the one whose mean is nearest to |mu| for the worst
    mu.
    """
    nodes, values = _solution()[:2]
    return np.where(y < REACH, np.interp(y, nodes, values), y)


def leftover() -> tuple[float, float]:
    """The largest bias of `unfolded`, and its largest standard deviation."""
    return _solution()[2:]


@lru_cache(maxsize=1)
def _solution() -> tuple[Array, Array, float, float]:
    """Nodes and values of `unfolded`, bias and scatter, by a linear programme."""
    nodes = np.arange(0, 2 * REACH + STEP / 2, STEP)
    mu = nodes[nodes <= REACH + 2][::2]
    mean = np.zeros((mu.size, nodes.size))
    for sign in (1, -1):
        mean += _normal_mass(sign * nodes - mu[:, None])
    mean[:, 0] /= 2
    free = nodes < REACH
    wanted = mu - mean[:, ~free] @ nodes[~free]
    n = int(np.count_nonzero(free))
    rise, last = np.eye(n, k=1) - np.eye(n), np.append(np.zeros(n - 1), nodes[n])
    worst, none = np.ones((mu.size, 1)), np.zeros((n, 1))
    rows = np.block(
        [[mean[:, free], -worst], [-mean[:, free], -worst], [rise, none], [-rise, none]]
    )
    steep = np.full(n, STEEPEST * STEP)
    limits = np.concatenate([wanted, -wanted, steep - last, steep + last])
    found = linprog(np.append(np.zeros(n), 1), rows, limits, bounds=(None, None))
    values = nodes.copy()
    values[free] = found.x[:-1]
    variance = mean @ values**2 - (mean @ values) ** 2
    return nodes, values, float(found.x[-1]), float(np.sqrt(variance.max()))


def _normal_mass(x: Array) -> Array:
    """Probability of a normal number within half a step of `x`."""
    low, high = ((x + side * STEP / 2) / np.sqrt(2) for side in (-1, 1))
    return (erf(high) - erf(low)) / 2
