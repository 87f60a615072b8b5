"""The furnace's stated errors cover the truth, also where hardly any walk goes."""

import numpy as np
import pytest

from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.scene import Scene
from msbsdf_cli.studies.furnace import FurnaceJob, run_furnace

THETA = (0.0, 1.0, 1.5, 1.57)
SAMPLES = 1024


@pytest.mark.parametrize("alpha", [0.3, 0.5, 1.0])
@pytest.mark.parametrize("slopes", ["beckmann", "ggx"])
@pytest.mark.parametrize("method", ["walk", "walk-low-variance", "exact"])
def test_errors_cover_what_no_walk_met(method, slopes, alpha):
    scene = Scene("conductor", (alpha, alpha), THETA, 0, slopes=slopes)
    solve = Solve(scene.distribution(), scene.facets(), scene.orders)
    known = np.array([solve.albedo(scene.wi(theta))[0][0] for theta in THETA])
    truth = np.concatenate([known, known.sum(axis=1, keepdims=True)], axis=1)
    result = run_furnace(FurnaceJob(scene, method, SAMPLES, 0, None))
    z = (result.value[:, 0] - truth) / result.stderr[:, 0]
    assert np.abs(z).max() < 6
    assert np.sqrt((z * z).mean()) < 1.7
    # No more is promised of any later order than one walk in all of them allows.
    assert (result.stderr[:, 0, 1:] >= 1 / SAMPLES).all()


def test_a_method_without_walks_misses_none():
    scene = Scene("conductor", (0.5, 0.5), (1.0,), 0)
    result = run_furnace(FurnaceJob(scene, "single", SAMPLES, 0, None))
    assert (result.stderr[0, 0, 1:-1] == 0).all()
    assert 0 < result.stderr[0, 0, 0] < 1 / SAMPLES
