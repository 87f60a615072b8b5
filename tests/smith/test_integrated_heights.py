"""The recursion over heights against heights drawn at random."""

import numpy as np
import pytest

from msbsdf_cli.smith.integrated_heights import arriving_heights

PATTERNS = ["", "d", "u", "du", "uu", "ud", "udu", "duud", "uudd", "dudu", "uduud", "ududud"]


@pytest.mark.parametrize("pattern", PATTERNS)
def test_chances_along_a_pattern_of_ups_and_downs(pattern):
    rng = np.random.default_rng(len(pattern))
    samples = 100000
    L = rng.uniform(0.3, 2, len(pattern) + 1)
    L[0] += 1
    x = rng.uniform(0.2, 2)
    descent = arriving_heights(L[:1], turns=True)
    t, alive = rng.exponential(1 / L[0], samples), np.ones(samples, bool)
    for way, L_i in zip(pattern, L[1:], strict=True):
        step = rng.exponential(1 / L_i, samples)
        if way == "d":
            t, descent = t + step, descent.downward(np.array([L_i]))
        else:
            alive &= step < t
            t, descent = t - step, descent.upward(np.array([L_i]))
    leaves = np.where(alive, np.exp(-x * np.abs(t)), 0)
    exact, arrives = descent.leaving(np.array([x, 0.0]))[0][0]
    assert abs(leaves.mean() - exact) < 4 * leaves.std() / np.sqrt(samples)
    assert abs(alive.mean() - arrives) <= 4 * alive.std() / np.sqrt(samples)


def test_equal_slants_do_not_divide_by_zero():
    # Differences of Laplace transforms are 0 / 0 here.
    descent = arriving_heights(np.array([2.0]), turns=False)
    for _ in range(3):
        descent = descent.upward(np.array([2.0]))
    assert descent.leaving(np.array([2.0]))[0][0, 0] == pytest.approx(2.0**-4)
