"""What a measurement of an identity says: a figure, its error, and the probability of such a
figure.

Every kind of evidence answers the same questions: how likely is a deviation at least this large
if the identity holds (`p_value`, None where chance plays no part), which deviation would be taken
for a failure at a given level (`tolerance`), and how wrong must a program be to be found out nine
times in ten (`detectable`).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy import stats
from scipy.optimize import brentq

from surfaces.facet import Array

FOUND = 0.9
"""Chance to be found out, of the error that `detectable` speaks of."""

LEAST_EXPECTED = 10.0
"""Cells of a chi-square test that expect fewer counts are pooled, or the statistic would not be
chi-square distributed."""


ROUNDING = 1e-12
"""Relative rounding of a mean."""


class TestStatistic(Protocol):
    """A measured figure beside the expected one."""

    @property
    def expected(self) -> float:
        """What the identity says."""

    @property
    def measured(self) -> float:
        """What came out."""

    @property
    def stderr(self) -> float:
        """Standard error of the difference of the two; 0 without noise."""

    @property
    def reason(self) -> str:
        """Why the tolerance is what it is."""

    def p_value(self) -> float | None:
        """Chance of a deviation at least as large, if the identity holds."""

    def tolerance(self, level: float) -> float:
        """Largest deviation that is no failure where p-values below `level` are failures."""

    def detectable(self, level: float) -> float:
        """Error of the program that would have been found with the probability `FOUND`."""


@dataclass(frozen=True)
class Mean:
    """A mean of independent batches, or a difference of such means: Student's t, corrected for the
    skewness of the batches.

    Estimates of light are skewed: most fall a little short, and those with the smallest scatter
    most of all, so that t alone fails far more often than it says. Hall's transformation (1992, On
    the Removal of Skewness by Transformation) t -> ((1 + g t / 3)^3 - 1) / g + g / 6 removes the
    skewness g of the mean, and has an inverse.
    """

    expected: float
    measured: float
    stderr: float
    df: float
    """Degrees of freedom of the standard error."""
    slack: float = 0.0
    """Known error of the expected figure, from a quadrature or a table."""
    because: str = ""
    """Where the slack comes from."""
    skewness: float = 0.0
    """Of the measured mean, less the expected one where that is measured as well."""

    @property
    def reason(self) -> str:
        text = f"Student's t of {self.df:.0f} degrees of freedom times stderr"
        return text + (", corrected for skewness" if self.skewness else "") + _plus(self)

    def p_value(self) -> float | None:
        deviation = self.measured - self.expected
        beyond = np.copysign(max(abs(deviation) - self._room, 0.0), deviation)
        if self.stderr == 0:
            return 1.0 if beyond == 0 else 0.0
        if beyond == 0:
            return 1.0
        t = self._unskewed(beyond / self.stderr)
        return float(min(2 * stats.t.sf(abs(t), self.df), 1.0))

    def tolerance(self, level: float) -> float:
        side = np.copysign(1.0, self.measured - self.expected)
        cut = side * float(stats.t.isf(level / 2, self.df))
        return self._room + abs(self._skewed(cut)) * self.stderr

    def detectable(self, level: float) -> float:
        return self.tolerance(level) + float(stats.norm.ppf(FOUND)) * self.stderr

    @property
    def _room(self) -> float:
        """The slack, and rounding, which is all the noise of an integrand that is constant."""
        return self.slack + ROUNDING * abs(self.expected)

    def _unskewed(self, t: float) -> float:
        g = self.skewness
        return t if g == 0 else float(((1 + g * t / 3) ** 3 - 1) / g + g / 6)

    def _skewed(self, t: float) -> float:
        g = self.skewness
        return t if g == 0 else float(3 / g * (np.cbrt(1 + g * (t - g / 6)) - 1))


@dataclass(frozen=True)
class Share:
    """How often something happened in n independent trials; exact, however rare it is."""

    expected: float
    count: int
    n: int
    slack: float = 0.0
    because: str = ""

    @property
    def measured(self) -> float:
        return self.count / self.n

    @property
    def stderr(self) -> float:
        return float(np.sqrt(self.expected * (1 - self.expected) / self.n))

    @property
    def reason(self) -> str:
        return f"binomial distribution of {self.n} trials" + _plus(self)

    def p_value(self) -> float | None:
        p = self._nearest()
        below = stats.binom.cdf(self.count, self.n, p)
        above = stats.binom.sf(self.count - 1, self.n, p)
        return float(min(2 * min(below, above), 1.0))

    def tolerance(self, level: float) -> float:
        p = self._nearest()
        if self.measured >= self.expected:
            room = stats.binom.isf(level / 2, self.n, p) / self.n - p
        else:
            room = p - stats.binom.ppf(level / 2, self.n, p) / self.n
        return self.slack + float(room)

    def detectable(self, level: float) -> float:
        return self.tolerance(level) + float(stats.norm.ppf(FOUND)) * self.stderr

    def _nearest(self) -> float:
        """Of all values that the expected one may have, the nearest to the measured one."""
        low, high = max(self.expected - self.slack, 0.0), min(self.expected + self.slack, 1.0)
        return float(np.clip(self.measured, low, high))


@dataclass(frozen=True)
class ChiSquare:
    """Counts against expected counts; the figures are the statistic and its expectation."""

    measured: float
    df: int
    because: str = ""

    @classmethod
    def of_counts(cls, counts: Array, expected: Array, because: str = "") -> "ChiSquare | None":
        """Counts in cells, of independent trials, against what each cell expects; None where all
        but one cell expect next to nothing, and nothing can be told."""
        small = expected < LEAST_EXPECTED
        cells, wanted = counts[~small], expected[~small]
        if expected[small].sum() >= LEAST_EXPECTED:
            cells = np.append(cells, counts[small].sum())
            wanted = np.append(wanted, expected[small].sum())
        elif small.any() and wanted.size:
            cells, wanted = cells.astype(float), wanted.copy()
            least = np.argmin(wanted)
            cells[least] += counts[small].sum()
            wanted[least] += expected[small].sum()
        if wanted.size < 2:
            return None
        return cls(float(((cells - wanted) ** 2 / wanted).sum()), wanted.size - 1, because)

    @classmethod
    def of_two(cls, one: Array, two: Array, because: str = "") -> "ChiSquare | None":
        """Counts of two independent samples in the same cells: are they of one distribution?"""
        share = one.sum() / (one.sum() + two.sum())
        expected = (one + two) * min(share, 1 - share)
        small = expected < LEAST_EXPECTED
        if 0 < expected[small].sum() < LEAST_EXPECTED and not small.all():
            # The rare cells together are still too rare: the next one joins them.
            small[np.argmin(np.where(small, np.inf, expected))] = True
        both = np.stack([one, two]).astype(float)
        pool = both[:, small].sum(axis=1, keepdims=True)
        table = np.concatenate([both[:, ~small], pool], axis=1)
        table = table[:, table.sum(axis=0) > 0]
        if table.shape[1] < 2:
            return None
        wanted = table.sum(axis=1, keepdims=True) * table.sum(axis=0) / table.sum()
        statistic = float(((table - wanted) ** 2 / wanted).sum())
        return cls(statistic, table.shape[1] - 1, because)

    @property
    def expected(self) -> float:
        return float(self.df)

    @property
    def stderr(self) -> float:
        return float(np.sqrt(2 * self.df))

    @property
    def reason(self) -> str:
        text = f"chi-square of {self.df} degrees of freedom"
        return f"{text}: {self.because}" if self.because else text

    def p_value(self) -> float | None:
        return float(stats.chi2.sf(self.measured, self.df))

    def tolerance(self, level: float) -> float:
        return float(stats.chi2.isf(level, self.df)) - self.df

    def detectable(self, level: float) -> float:
        """As an excess of the statistic: n times the sum of (relative error)^2 x probability."""
        cut = stats.chi2.isf(level, self.df)
        return float(brentq(lambda x: stats.ncx2.sf(cut, self.df, x) - FOUND, 1e-3, 40 * cut))


@dataclass(frozen=True)
class Exact:
    """Two figures without noise, which a known error of rounding or quadrature may part."""

    expected: float
    measured: float
    slack: float
    because: str
    stderr = 0.0

    @property
    def reason(self) -> str:
        return self.because

    def p_value(self) -> float | None:
        return None

    def tolerance(self, level: float) -> float:
        return self.slack

    def detectable(self, level: float) -> float:
        return self.slack


def _plus(evidence: Mean | Share) -> str:
    return f", plus {evidence.slack:.1g}: {evidence.because}" if evidence.slack else ""
