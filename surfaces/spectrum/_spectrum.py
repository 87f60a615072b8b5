"""What a spectrum of heights is, and what follows from its shape alone.

A field has unit height variance and, along each axis, the slope variance 2, whatever its spectrum:
its unit of length follows from that. So a surface of roughness alpha has Beckmann's slopes of
variance alpha^2 / 2 once it is stretched by 2 / alpha, and spectra differ in nothing but how
heights correlate.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from math import factorial

import numpy as np
from scipy.special import j0, j1

from surfaces.facet import Array
from surfaces.quadrature import gauss

LEAST_PHASE = 0.5
"""Below, the recurrence of Bessel functions loses digits, and `TERMS` terms of their series are
right to the last one."""

TERMS = 7

PHASES = 1 << 14
"""Of derivatives, taken at once: some arrays of these stay in a core's cache."""

NODES = 400
"""Between kinks of a spectrum: some for each wave of its autocorrelation at 20 lengths."""


@dataclass(frozen=True)
class Spectrum(ABC):
    """An isotropic power spectrum up to the wave number `k_max`, above which there is nothing."""

    @property
    @abstractmethod
    def name(self) -> str:
        """As on the command line."""

    @abstractmethod
    def shape(self, q: Array) -> Array:
        """Power per area of wave vectors, up to a factor, over wave numbers in any unit."""

    @property
    @abstractmethod
    def knots(self) -> tuple[float, ...]:
        """Wave numbers between which the shape is smooth; the last is where it ends."""

    @cached_property
    def waves(self) -> tuple[Array, Array]:
        """Wave numbers and the power at each, which sums to 1, in the field's unit of length."""
        x, weight = gauss(NODES)
        q, power = [], []
        for low, high in zip((0.0, *self.knots[:-1]), self.knots, strict=True):
            q.append(low + (high - low) * x)
            power.append(self.shape(q[-1]) * q[-1] * (high - low) * weight)
        wave, share = np.concatenate(q), np.concatenate(power)
        share /= share.sum()
        # The slope variance along an axis is half of the mean square of wave numbers.
        return wave * (2 / np.sqrt(share @ wave**2)), share

    @cached_property
    def length(self) -> float:
        """The unit of wave numbers of `shape`, in the field's."""
        return float(self.knots[-1] / self.k_max)

    @cached_property
    def k_max(self) -> float:
        """Wave number, in the field's unit, beyond which no wave is laid."""
        wave, _ = self.waves
        x, _ = gauss(NODES)
        low = self.knots[-2] if len(self.knots) > 1 else 0.0
        return float(wave[-1] * self.knots[-1] / (low + (self.knots[-1] - low) * x[-1]))

    def power(self, k: Array) -> Array:
        """Power per area of wave vectors, up to a factor, at wave numbers of the field."""
        return np.where(k <= self.k_max, self.shape(np.minimum(k, self.k_max) * self.length), 0)

    def autocorrelation(self, r: Array) -> Array:
        """Of heights, distances `r` (n,) apart."""
        wave, share = self.waves
        return np.asarray(j0(np.multiply.outer(r, wave)) @ share)

    def derivatives(self, r: Array) -> Array:
        """The autocorrelation at distances `r` (n,) and its first four derivatives, (5, n)."""
        wave, share = self.waves
        found = np.empty((5, r.size))
        some = -(-PHASES // wave.size)
        for start in range(0, r.size, some):
            J = _bessel(np.multiply.outer(r[start : start + some], wave))
            bends = (
                J[0],
                -J[1],
                (J[2] - J[0]) / 2,
                (3 * J[1] - J[3]) / 4,
                (3 * J[0] - 4 * J[2] + J[4]) / 8,
            )
            for n, bend in enumerate(bends):
                found[n, start : start + some] = bend @ (share * wave**n)
        return found

    @cached_property
    def correlation_length(self) -> float:
        """Distance at which the autocorrelation has fallen to 1/e."""
        return self.distance(1 / np.e)

    def distance(self, level: float) -> float:
        """Distance at which the autocorrelation has fallen to `level`, between 0.2 and 1."""
        # Not above: it takes longer to import than many a run takes.
        from scipy.optimize import brentq

        r = np.linspace(0, 40, 4001)
        first = int(np.argmax(self.autocorrelation(r) < level))
        ends = r[first - 1], r[first]
        return float(brentq(lambda x: self.autocorrelation(np.array([x]))[0] - level, *ends))

    def chord_variance(self, cells: float) -> float:
        """Variance of the slope over a cell, along an axis, over that at a point; less than 1."""
        wave, share = self.waves
        return float(((1 - j0(wave / cells)) @ share) * cells**2)


def _bessel(phase: Array) -> list[Array]:
    """Bessel functions of the first kind, of orders 0 to 4."""
    J = [j0(phase), j1(phase)]
    small, large = np.minimum(phase, LEAST_PHASE), np.maximum(phase, LEAST_PHASE)
    q = -small * small / 4
    for n in range(1, 4):
        upward = (2 * n) / large * J[n] - J[n - 1]
        series = np.ones_like(q)
        for k in range(TERMS - 1, 0, -1):
            series *= q / (k * (n + 1 + k))
            series += 1
        series *= (small / 2) ** (n + 1) / factorial(n + 1)
        J.append(np.where(phase < LEAST_PHASE, series, upward))
    return J
