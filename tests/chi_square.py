"""One chi-square test for every sampler."""

import numpy as np
from scipy import stats


def chi_square_p(counts: np.ndarray, expected: np.ndarray, least: float = 10.0) -> float:
    """p-value of counts against expected counts; cells expecting fewer than `least` are pooled,
    so that the statistic is chi-square distributed."""
    counts, expected = counts.ravel(), expected.ravel()
    small = expected < least
    pooled = np.append(counts[~small], counts[small].sum())
    wanted = np.append(expected[~small], expected[small].sum())
    if wanted[-1] < least:
        pooled = np.append(pooled[:-2], pooled[-2:].sum())
        wanted = np.append(wanted[:-2], wanted[-2:].sum())
    statistic = ((pooled - wanted) ** 2 / wanted).sum()
    return float(stats.chi2.sf(statistic, len(wanted) - 1))
