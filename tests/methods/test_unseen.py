"""The error of what walks have not found: large enough where they rarely go, and no larger."""

import numpy as np
import pytest
from spheres import direction, error

from msbsdf_cli.methods.directions import exits
from msbsdf_cli.methods.exact import Exact
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.methods.unseen import unseen
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
        off = got.value[:, 1:] - expected
        z[seed] = off / error(got)[:, 1:]
        naive[seed] = off / np.maximum(got.stderr[:, 1:], 1e-300)
    # Where paths come about once in a run, a value is as skewed as a Poisson number of mean 1,
    # which is 5 or more once in 270; the larger part of these values are such.
    assert (np.abs(z) > 4).mean() < 0.004
    assert (np.abs(naive) > 4).mean() > 0.1


@pytest.mark.parametrize(
    ("material", "bound"),
    # A diffuse facet sends at most 1/pi anywhere. A mirror's D(h) / (4 sigma), D at most
    # 1 / (pi alpha^2), is below 20 if sigma is above 0.04, as towards all but steep directions.
    [(Diffuse((1.0,)), 1 / np.pi), (Conductor(), 20), (Dielectric(1.5), 200)],
    ids=lambda x: getattr(x, "name", ""),
)
def test_one_walk_adds_what_a_facet_sends(material, bound):
    out = exits(SMOOTH, WO)
    added = 1000 * unseen(SMOOTH, material, out, 1000, RNG(1))
    assert (added <= bound).all()
    assert (added > 0.05).all()


def test_nothing_is_missing_where_no_light_goes():
    below = exits(SMOOTH, np.concatenate([-WO, direction([np.pi / 2])], axis=1))
    below.w[2, -1] = 0
    assert (unseen(SMOOTH, Conductor(), below, 10, RNG(1)) == 0).all()


def test_steep_directions_count_by_their_chance_to_meet_a_facet():
    # Just below the zenith facets are seen at a glance: 1e9 a steradian, once in 1e40 walks.
    out = exits(SMOOTH, direction([0.02]))
    assert unseen(SMOOTH, Conductor(), out, 10**6, RNG(1))[0] < 1e-5
