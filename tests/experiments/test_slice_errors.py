"""Errors along a slice, and their error bars."""

import numpy as np
import pytest

from msbsdf_cli.experiments.evaluate import Values
from msbsdf_cli.experiments.slice_errors import slice_errors

N, GROUPS = 12, 16


def values(method, value, stderr=None, groups=None):
    """Of one channel and order, and of their sum."""
    both = [np.tile(a, (1, 2, 1)) for a in (value, np.zeros(N) if stderr is None else stderr)]
    return Values(method, 1.0, *both, 0.0, 0.0, groups=groups)


@pytest.mark.parametrize("off", [0.0, 0.3])
def test_error_bars_know_that_directions_share_walks(off):
    """All directions have the noise of one number, half of them with the other sign, so that it
    cancels in their sum, but not in that of sizes."""
    rng, sign = np.random.default_rng(1), np.where(np.arange(N) % 2, 1.0, -1.0)
    truth, found, stated = values("solve", np.ones(N)), [], []
    for _ in range(300):
        groups = 1 + off * sign + 0.2 * rng.standard_normal((GROUPS, 1)) * sign
        stderr = groups.std(axis=0, ddof=1) / np.sqrt(GROUPS)
        walk = values("walk", groups.mean(axis=0), stderr, groups[:, None])
        (row,) = slice_errors([walk, truth], 0.0)
        assert (row.method, row.against) == ("walk", "solve")
        found.append(row.error)
        stated.append(row.stderr)
    spread, bar = np.std(found), np.mean(stated)
    # A standard deviation of 300 numbers is known to 4 %; the bars hold the bias left as well.
    assert 0.85 * spread < bar < 2.5 * spread
    assert abs(np.mean(found) - off) < 0.2 * 0.2 / np.sqrt(GROUPS) + 4 * spread / np.sqrt(300)


def test_without_noise_the_error_is_what_methods_state():
    rows = slice_errors(
        [values("single", np.full(N, 0.9)), values("solve", np.ones(N), np.full(N, 0.01))], 0.0
    )
    assert rows[0].error == pytest.approx(0.1)
    assert rows[0].stderr == pytest.approx(0.01)


def test_nothing_is_held_against_what_is_not_the_whole_model():
    assert slice_errors([values("single", np.ones(N))], 0.0) == []
