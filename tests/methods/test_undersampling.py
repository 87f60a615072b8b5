"""The error of what walks have not found: large enough where they rarely go, and no larger."""

import numpy as np
import pytest
from spheres import direction

from msbsdf_cli.methods.base import outgoing
from msbsdf_cli.methods.exact import Exact
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.methods.undersampling import undersampling_bound
from msbsdf_cli.methods.walk import Walk
from msbsdf_cli.methods.walk_low_variance import WalkLowVariance
from msbsdf_cli.smith.slopes import Beckmann
from surfaces.materials import Conductor, Dielectric, Diffuse

RNG = np.random.default_rng
SMOOTH = Beckmann(0.3, 0.3)
WO = direction([0.3, 0.7, 1.2, 1.35, 0.7, 1.3], [3, 3, 3, 3.1, 0.1, 0.1])


@pytest.mark.parametrize("method", [Walk, WalkLowVariance, Exact])
@pytest.mark.parametrize("theta", [0.5, 1.5])
def test_rare_paths_are_within_the_error(method, theta):
    wi, runs = direction(theta), 40
    expected = Solve(SMOOTH, Conductor(), 4).evaluate(wi, WO).value[:, 1:]
    model = method(SMOOTH, Conductor(), 4)
    z, naive = np.zeros((2, runs, *expected.shape))
    for seed in range(runs):
        got = model.evaluate(wi, WO, 4000, RNG(seed))
        unseen = model.undersampling(wi, WO, 4000, RNG(seed))[:, None]
        off, stderr = got.value[:, 1:] - expected, got.stderr[:, 1:]
        z[seed], naive[seed] = off / np.hypot(stderr, unseen), off / np.maximum(stderr, 1e-300)
    # Where paths come about once in a run, a value is as skewed as a Poisson number of mean 1,
    # which is 5 or more once in 270; the larger part of these values are such.
    assert (np.abs(z) > 4).mean() < 0.004
    assert (np.abs(naive) > 4).mean() > 0.1


@pytest.mark.parametrize(
    ("material", "bound"),
    # A diffuse facet sends at most 1/pi anywhere. A mirror's D(h) / (4 sigma), D at most
    # 1 / (pi alpha^2), is below 40 if sigma is above 0.02, as towards all but steep directions.
    [(Diffuse((1.0,)), 1 / np.pi), (Conductor(), 40), (Dielectric(1.5), 200)],
    ids=lambda x: getattr(x, "name", ""),
)
def test_one_walk_adds_what_a_facet_sends(material, bound):
    added = 1000 * undersampling_bound(SMOOTH, material, outgoing(SMOOTH, WO), 1000, RNG(1))
    assert added.shape == (1, WO.shape[1])
    assert (added <= bound).all()
    assert (added > 0.05).all()


def test_what_is_absorbed_is_not_missing():
    out = outgoing(SMOOTH, WO)
    white, grey, black = undersampling_bound(SMOOTH, Diffuse((1.0, 0.5, 0.0)), out, 1000, RNG(1))
    np.testing.assert_allclose(grey, white / 2)
    assert (black == 0).all()
    metal = undersampling_bound(SMOOTH, Conductor(((0.2, 3.9),)), out, 1000, RNG(1))
    mirror = undersampling_bound(SMOOTH, Conductor(), out, 1000, RNG(1))
    assert (metal < mirror).all()
    assert (metal > 0.8 * mirror).all()


def test_nothing_is_missing_where_no_light_goes():
    below = outgoing(SMOOTH, np.concatenate([-WO, direction([np.pi / 2])], axis=1))
    below.w[2, -1] = 0
    assert (undersampling_bound(SMOOTH, Conductor(), below, 10, RNG(1)) == 0).all()
