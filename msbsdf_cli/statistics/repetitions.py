"""Errors of a method from independent repetitions: how large, how much of it is bias, how sure."""

from dataclasses import dataclass

import numpy as np

from msbsdf_cli.statistics.jackknife import jackknife
from surfaces.facet import Array


@dataclass(frozen=True)
class Squared:
    """Mean squared error of repetitions, taken apart; each with its standard error."""

    total: float
    total_stderr: float
    bias: float
    """Squared bias, without the noise that a mean of few repetitions has left: may be negative."""
    bias_stderr: float
    noise: float
    """What a repetition adds to the bias."""
    noise_stderr: float


def taken_apart(gram: Array) -> Squared:
    """From inner products (r, r) of the errors of r repetitions with each other.

    The diagonal holds squared errors. The mean of the others is the squared bias, since errors of
    different repetitions share nothing else (a U statistic). Its standard error is the larger of
    the jackknife's, which fails where there is no bias, and of that for no bias at all.
    """
    r = len(gram)
    own = np.diag(gram)
    if r == 1:
        return Squared(own[0], 0.0, own[0], 0.0, 0.0, 0.0)
    across = gram.sum(axis=1) - own
    bias = across.sum() / (r * (r - 1))
    if r == 2:
        return Squared(own.mean(), np.inf, bias, np.inf, own.mean() - bias, np.inf)
    bias_left = (across.sum() - 2 * across) / ((r - 1) * (r - 2))
    pairs = gram[np.triu_indices(r, 1)]
    by_chance = np.sqrt((pairs**2).sum()) / pairs.size
    noise_left = (own.sum() - own) / (r - 1) - bias_left
    return Squared(
        float(own.mean()),
        float(own.std(ddof=1) / np.sqrt(r)),
        float(bias),
        float(max(jackknife(bias_left), by_chance)),
        float(own.mean() - bias),
        jackknife(noise_left),
    )


def root(square: float, stderr: float) -> tuple[float, float]:
    """The root of a squared quantity and its standard error, 0 where noise has it negative."""
    if square <= 0:
        return 0.0, float(np.sqrt(stderr))
    value = float(np.sqrt(square))
    return value, float(min(stderr / (2 * value), np.sqrt(stderr)))


def inner_products(errors: Array, weight: Array) -> Array:
    """Integrals (r, r) over solid angle of products of errors (r, channels, n)."""
    flat = (errors * np.sqrt(weight)).reshape(len(errors), -1)
    return flat @ flat.T


def accuracy(values: Array, reference: Array, weight: Array) -> Squared:
    """Squared relative errors of the sum over orders of `values` (r, channels, orders + 1, n)
    against `reference` (channels, orders + 1, n) at directions of solid angles `weight` (n,)."""
    total, truth = (values - reference).sum(axis=2), reference.sum(axis=1)
    gram = inner_products(total, weight) / float((truth**2 * weight).sum())
    return taken_apart(gram)
