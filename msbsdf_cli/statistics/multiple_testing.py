"""Verdicts on many measurements at once: all of them hold together at one rate of error.

Holm's procedure bounds the probability that a correct program fails anywhere by `FAMILY_ERROR`,
whatever the dependence between the measurements. Without it, at a level of one in a thousand each,
half of all runs of a correct program would report a failure."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from msbsdf_cli.statistics.test_statistics import ChiSquare, Exact, TestStatistic
from msbsdf_cli.validation.configurations import Configuration

FAMILY_ERROR = 1e-3
"""Chance that a correct program fails in a run: once in a thousand runs."""

SMALLEST_P = 1e-300
"""So that a z-score stays finite."""

HOLDS, FAILS = "holds", "fails"
FAILS_AS_EXPECTED, HOLDS_UNEXPECTEDLY = "fails as expected", "holds against expectation"
AGREEMENT = "agreement"
BAD = (FAILS, HOLDS_UNEXPECTEDLY)
"""Verdicts that make a run fail."""


@dataclass(frozen=True)
class Finding:
    """One measurement of one identity."""

    identity: str
    section: str
    """Of [HHdD16 impl.], or the equation of the paper."""
    configuration: Configuration
    evidence: TestStatistic
    wanted: str = HOLDS
    """`holds`, `fails as expected` where an identity is known not to hold, or `agreement` where
    the model is an approximation and nothing is judged."""
    detail: tuple[float, ...] = ()
    """Single values behind the figure, where a picture shows them."""


@dataclass(frozen=True)
class Judged:
    """A finding and its verdict."""

    finding: Finding
    p_value: float | None
    z: float | None
    """Signed normal score of the p-value; for agreement, the difference in standard errors."""
    tolerance: float
    detectable: float
    verdict: str

    @property
    def failed(self) -> bool:
        return self.verdict in BAD


def holm(p_values: Sequence[float], family_error: float) -> float:
    """The level at or below which p-values are failures, by Holm's step-down procedure.

    Sorted, the k-th of m p-values must not exceed family_error / (m - k + 1), and the first that
    does ends the failures. With R failures, that is the same as one level, family_error / (m - R).
    """
    m = len(p_values)
    failures = 0
    for rank, p in enumerate(sorted(p_values)):
        if p > family_error / (m - rank):
            break
        failures += 1
    return family_error / max(m - failures, 1)


def judge(findings: Sequence[Finding], family_error: float = FAMILY_ERROR) -> list[Judged]:
    """Verdicts on all findings; where an identity is to fail, chance must be ruled out at the
    level that a failure of the others needs."""
    p_values = [_p_value(f.evidence) for f in findings]
    family = [
        p for f, p in zip(findings, p_values, strict=True) if p is not None and f.wanted == HOLDS
    ]
    level = holm(family, family_error)
    return [_judge(f, p, level) for f, p in zip(findings, p_values, strict=True)]


def _p_value(evidence: TestStatistic) -> float | None:
    """What is not a number has no probability to be right."""
    p = evidence.p_value()
    return 0.0 if p is not None and np.isnan(p) else p


def _judge(finding: Finding, p: float | None, level: float) -> Judged:
    evidence = finding.evidence
    tolerance = evidence.tolerance(level)
    deviation = evidence.measured - evidence.expected
    # By `not`, which also catches what is not a number.
    rejected = not abs(deviation) <= tolerance if p is None else p <= level
    if finding.wanted == AGREEMENT:
        verdict = AGREEMENT
    elif finding.wanted == FAILS_AS_EXPECTED:
        verdict = FAILS_AS_EXPECTED if rejected else HOLDS_UNEXPECTEDLY
    else:
        verdict = FAILS if rejected else HOLDS
    return Judged(finding, p, _z(finding, p), tolerance, evidence.detectable(level), verdict)


def _z(finding: Finding, p: float | None) -> float | None:
    evidence = finding.evidence
    deviation = evidence.measured - evidence.expected
    if p is None or isinstance(evidence, Exact):
        return None
    if finding.wanted == AGREEMENT:
        return deviation / evidence.stderr if evidence.stderr > 0 else None
    if isinstance(evidence, ChiSquare):
        return float(stats.norm.isf(np.clip(p, SMALLEST_P, 1 - 1e-16)))
    return float(np.copysign(stats.norm.isf(max(p, SMALLEST_P) / 2), deviation))
