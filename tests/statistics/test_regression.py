"""Regression on control variates against least squares, and over many repetitions."""

import numpy as np

from msbsdf_cli.statistics.regression import regress

ALL = slice(None)


def sums_of(y, c):
    """What `regress` takes, of units y (n, figures) with controls c (n, k)."""
    known = np.column_stack([np.ones(len(c)), c])
    return np.array([y.sum(axis=0), (y * y).sum(axis=0)]), c.T @ y, known.T @ known, ALL


def test_estimates_are_those_of_least_squares(rng):
    """The intercept of a fit by least squares, and its standard error."""
    c = rng.standard_normal((30, 2)) + 0.3
    y = (2 + c @ [1.0, -0.5] + 0.1 * rng.standard_normal(30))[:, None]
    value, variance = regress(*sums_of(y, c))
    design = np.column_stack([np.ones(30), c])
    fit, (rss,), _, _ = np.linalg.lstsq(design, y[:, 0], rcond=None)
    np.testing.assert_allclose(value, fit[0], rtol=1e-10)
    inverse = np.linalg.inv(design.T @ design)
    np.testing.assert_allclose(variance, rss / (30 - 3) * inverse[0, 0], rtol=1e-10)


def test_controls_that_do_not_vary_or_only_together_do_no_harm(rng):
    c = rng.standard_normal((30, 1))
    y = 2 + c + 0.1 * rng.standard_normal((30, 1))
    alone = regress(*sums_of(y, c))[0]
    more = np.column_stack([c, 2 * c, np.full(30, 1e-17)])
    np.testing.assert_allclose(regress(*sums_of(y, more))[0], alone, rtol=1e-6)


def test_controls_that_explain_nothing_are_left_alone(rng):
    kept = [
        regress(*sums_of(rng.standard_normal((16, 1)), rng.standard_normal((16, 3))))
        for _ in range(200)
    ]
    # They would multiply the variance by 14 / 11 in the mean.
    assert sum(found is None for found in kept) > 120
    assert regress(*sums_of(rng.standard_normal((5, 1)), rng.standard_normal((5, 3)))) is None


def test_stated_errors_are_the_spread_over_repetitions(rng):
    found = []
    for _ in range(400):
        c = rng.standard_normal((16, 3))
        y = (c.sum(axis=1) + rng.standard_normal(16))[:, None]
        found.append(regress(*sums_of(y, c)))
    # By chance they seem to be of no use in some.
    used = [np.ravel(f) for f in found if f is not None]
    values, variances = np.array(used).T
    assert len(used) > 380
    # 400 repetitions know their spread to 3.5 %.
    assert abs(values.std() / np.sqrt(variances.mean()) - 1) < 0.14
    assert abs(values.mean()) < 4 * values.std() / 20
