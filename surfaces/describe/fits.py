"""Slope distributions fitted to the slopes of facets, with error bars and misfits.

All three are Student's t (M. Ribardiere et al., STD: Student's t-Distribution of Slopes, Computer
Graphics Forum 36(2), 2017): with tail = 1 / (gamma - 1) the density of slopes, each over its
roughness, is (1 + tail r^2)^(-1 - 1/tail) / pi; Beckmann's is the limit of tail 0, GGX has tail 1.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.special import erfc, stdtr

from surfaces.describe.quantities import SMALL, Quantity
from surfaces.describe.spread import block_means, covariance, stderr
from surfaces.facet import Array

MOST = 1 << 20
"""Facets that are fitted to, evenly spaced: what lies between is like them."""

LEAST_TAIL, MOST_TAIL = 1e-3, 1.98
"""A thousand and more is Beckmann's; from a gamma of 1.5 on a surface has no finite area."""


class Fit(NamedTuple):
    """Roughness and tail, covariance of (log alpha_x, log alpha_y, tail) and misfit."""

    alpha_x: float
    alpha_y: float
    tail: float
    covariance: Array
    misfit: float
    misfit_stderr: float


@dataclass(frozen=True)
class Kind:
    """A family of distributions: its tail, None where that is fitted."""

    name: str
    tail: float | None


KINDS = (Kind("beckmann", 0.0), Kind("ggx", 1.0), Kind("student_t", None))


def fitted(slopes: Array, kind: Kind) -> Fit:
    """Maximum likelihood for slopes (2, nx, ny).

    Slopes that are near each other are alike: error bars come from what the derivatives of the
    likelihood scatter over the patch (the sandwich estimator).
    """
    every = int(np.ceil(np.sqrt(slopes[0].size / MOST)))
    slopes = slopes[:, ::every, ::every]
    free = slice(0, 2 if kind.tail is not None else 3)
    start = np.append(
        np.log(np.sqrt(2 * (slopes**2).mean(axis=(1, 2)))), 0.3 if kind.tail is None else kind.tail
    )

    def full(x: Array) -> Array:
        return np.append(x, start[2]) if kind.tail is not None else x

    def objective(x: Array) -> tuple[float, Array]:
        value, derivatives = _log_density(slopes, full(x))
        return -float(value.mean()), -np.array([d.mean() for d in derivatives])[free]

    bounds = [(None, None)] * 2 + [(LEAST_TAIL, MOST_TAIL)]
    x = start[free]
    if kind.tail != 0:
        options = {"ftol": 1e-13, "gtol": 1e-9}
        found = minimize(
            objective, x, jac=True, method="L-BFGS-B", bounds=bounds[free], options=options
        )
        x = found.x
    errors = _sandwich(slopes, full(x), free)
    alpha_x, alpha_y = np.exp(x[:2]).tolist()
    tail = float(full(x)[2])
    return Fit(alpha_x, alpha_y, tail, errors, *_misfit(slopes, (alpha_x, alpha_y), tail))


def _log_density(slopes: Array, parameters: Array) -> tuple[Array, list[Array]]:
    """Logarithm of the density, and its derivatives by log alpha_x, log alpha_y and tail."""
    log_x, log_y, tail = parameters
    u, v = (slopes[0] * np.exp(-log_x)) ** 2, (slopes[1] * np.exp(-log_y)) ** 2
    r2 = u + v
    if tail == 0:
        return -r2 - log_x - log_y, [2 * u - 1, 2 * v - 1, r2 * r2 / 2 - r2]
    q = 1 + tail * r2
    log_q = np.log(q)
    by_tail = (log_q / tail - (tail + 1) * r2 / q) / tail
    by_alpha = [2 * (1 + tail) * w / q - 1 for w in (u, v)]
    return -(1 + 1 / tail) * log_q - log_x - log_y, [*by_alpha, by_tail]


def _sandwich(slopes: Array, parameters: Array, free: slice) -> Array:
    """Covariance (3, 3) of the parameters; 0 for those that are not fitted."""
    scores = np.stack([block_means(d) for d in _log_density(slopes, parameters)[1]])[free]
    columns = []
    for i in range(len(scores)):
        step = np.zeros(3)
        step[i] = SMALL
        up, down = (
            np.array([d.mean() for d in _log_density(slopes, parameters + s)[1]])[free]
            for s in (step, -step)
        )
        columns.append((up - down) / (2 * SMALL))
    bread = np.linalg.inv(np.stack(columns, axis=1))
    full = np.zeros((3, 3))
    full[free, free] = bread @ covariance(scores) @ bread.T
    return full


def _misfit(slopes: Array, alpha: tuple[float, float], tail: float) -> tuple[float, float]:
    """Kolmogorov-Smirnov distance of the slopes along x or y, whichever is larger, and what noise
    it has where it is found."""
    worst = (0.0, 0.0)
    for slope, a in zip(slopes, alpha, strict=True):
        x = np.sort(slope, axis=None)
        model = _below(x / a, tail)
        empirical = (np.arange(x.size) + 0.5) / x.size
        at = int(np.argmax(np.abs(model - empirical)))
        distance = float(np.abs(model - empirical)[at])
        if distance > worst[0]:
            worst = distance, stderr((slope <= x[at]).astype(float))
    return worst


def _below(x: Array, tail: float) -> Array:
    """Distribution function of one slope over its roughness: t / sqrt(2), of 2 / tail degrees of
    freedom."""
    return np.asarray(erfc(-x) / 2 if tail == 0 else stdtr(2 / tail, np.sqrt(2) * x))


def fits(slopes: Array) -> list[Quantity]:
    """Roughness by each distribution and its misfit."""
    rows = []
    for kind in KINDS:
        fit = fitted(slopes, kind)
        name, errors = kind.name, np.sqrt(np.diag(fit.covariance))
        for axis, alpha, error in zip("xy", fit[:2], errors, strict=False):
            rows.append(Quantity(f"{name}_alpha_{axis}", alpha, float(alpha * error)))
        if kind.tail is None:
            beyond = fit.tail <= 2 * LEAST_TAIL
            note = "as Beckmann's: the tail is too short to tell" if beyond else ""
            gamma, error = 1 + 1 / fit.tail, float(errors[2]) / fit.tail**2
            rows.append(Quantity(f"{name}_gamma", gamma, error, "", note))
        note = "Kolmogorov-Smirnov distance of slopes along an axis"
        rows.append(Quantity(f"{name}_misfit", fit.misfit, fit.misfit_stderr, "", note))
    return rows
