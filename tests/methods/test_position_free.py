"""The position-free models: their published numbers, estimators and (non-)reciprocity."""

import numpy as np
import pytest
from spheres import direction, evaluated, hemisphere, largest_z

from msbsdf_cli.methods.exact import Exact
from msbsdf_cli.methods.path_factors import leaving_probability, meeting_probability
from msbsdf_cli.methods.position_free import PositionFreeCorrelated, PositionFreeUncorrelated
from msbsdf_cli.methods.protocol import Evaluation
from msbsdf_cli.methods.walk import Walk
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from surfaces.materials import Conductor, Dielectric, Diffuse

RNG = np.random.default_rng
MODELS = [PositionFreeUncorrelated, PositionFreeCorrelated]


@pytest.mark.parametrize(
    ("method", "expected"),
    [
        (Walk, [0.471, 0.448, 0.076]),
        (PositionFreeUncorrelated, [0.471, 0.464, 0.062]),
        (PositionFreeCorrelated, [0.472, 0.477, 0.049]),
    ],
)
def test_energies_per_order(method, expected):
    model, wi = method(Beckmann(1, 1), Conductor(), 3), direction(np.radians(10))
    w, solid_angle = hemisphere(10)
    batches = [
        (model.evaluate(wi, w, 500, RNG(seed)).value[0, :3] * solid_angle).sum(axis=1)
        for seed in range(40)
    ]
    mean, stderr = np.mean(batches, axis=0), np.std(batches, axis=0, ddof=1) / np.sqrt(40)
    # 2e-3: the numbers given were sampled too.
    assert (np.abs(mean - expected) < 4 * stderr + 2e-3).all()
    # Near enough to tell the models apart.
    assert stderr[2] < 2e-3


@pytest.mark.parametrize(
    ("method", "expected"),
    [(Exact, 0.126), (PositionFreeUncorrelated, 0.182), (PositionFreeCorrelated, 0.274)],
)
def test_multiple_scattering_out_of_plane(method, expected):
    wi, wo = direction(np.radians(30)), direction(np.radians(75), np.pi / 2)
    got = method(Ggx(1, 1), Conductor(), 1).evaluate(wi, wo[:, None], 60000, RNG(1))
    f, stderr = got.value[0, 1, 0] / wo[2], got.stderr[0, 1, 0] / wo[2]
    assert abs(f - expected) < 4 * stderr + 0.002


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(
    "material", [Conductor(((0.2, 3.9), (1.5, 2.0))), Diffuse((0.9, 0.3)), Dielectric(1.5)]
)
@pytest.mark.parametrize("theta", [0.3, 1.3])
def test_both_estimators_agree(model, material, theta):
    wi, wo = direction(theta, 0.4), direction([0.3, 1.2], [0.5, 3.0])
    if material.transmits:
        wo = np.concatenate([wo, -wo], axis=1)
    one = evaluated(model(Ggx(1, 1), material, 2), wi, wo, 60000, RNG(1))
    both_ends = model(Ggx(1, 1), material, 2, bidirectional=True)
    two = evaluated(both_ends, wi, wo, 4000, RNG(2))
    assert largest_z(one, two) < 4.5


@pytest.mark.parametrize("slopes", [Beckmann(1, 1), Ggx(1, 0.4)])
def test_uncorrelated_heights_are_reciprocal(slopes):
    there, back = _both_ways(PositionFreeUncorrelated(slopes, Conductor(), 2))
    assert largest_z(there, back) < 4


def test_correlated_heights_are_not():
    there, back = _both_ways(PositionFreeCorrelated(Beckmann(1, 1), Conductor(), 2))
    ratio = there.value[0, 1] / back.value[0, 1]
    relative = [e.stderr[0, 1] / e.value[0, 1] for e in (there, back)]
    stderr = ratio * np.hypot(*relative)
    assert (ratio - 4 * stderr > 1).all()
    assert (ratio < 1.7).all()
    np.testing.assert_allclose(there.value[0, 0], back.value[0, 0])


def _both_ways(model):
    a, b = direction(0.2), direction([0.9, 1.3], [0.3, 2.0])
    there = evaluated(model, a, b, 100000, RNG(1))
    value, stderr = np.zeros_like(there.value), np.zeros_like(there.value)
    for k in range(2):
        back = evaluated(model, b[:, k], a[:, None], 100000, RNG(2 + k))
        value[..., k] = back.value[..., 0] * b[2, k] / a[2]
        stderr[..., k] = back.stderr[..., 0] * b[2, k] / a[2]
    return there, Evaluation(value, stderr)


@pytest.mark.parametrize("correlated", [False, True])
@pytest.mark.parametrize("through", [False, True])
def test_light_either_leaves_or_meets_another_facet(correlated, through):
    rng = np.random.default_rng(5)
    d = direction(np.pi * rng.random(200), 6 * rng.random(200))
    L, L_next = 1 + rng.exponential(2, 200), rng.exponential(2, 200)
    leaves = leaving_probability(L, d, L_next, through, correlated)
    meets = meeting_probability(L, d, L_next, through, correlated)
    np.testing.assert_allclose(leaves + meets, 1, rtol=1e-12)
    assert (leaves[d[2] < 0] == 0).all()


def test_leaving_chance_is_that_of_heights_spread_by_the_last_direction():
    # Arriving along L puts C1 = exp(-t) with t exponential of rate L; leaving takes C1^Lambda,
    # and (1 - C1)^Lambda on the other side.
    rng = np.random.default_rng(6)
    L, Lambda, up = np.array([1.7]), np.array([0.6]), direction(0.5)[:, None]
    C1 = np.exp(-rng.exponential(1 / L, 200000))
    for through, heights in ((False, C1), (True, 1 - C1)):
        sampled = heights**Lambda
        chance = leaving_probability(L, up, Lambda, through, correlated=True)[0]
        assert abs(sampled.mean() - chance) < 4 * sampled.std() / np.sqrt(sampled.size)
    assert leaving_probability(L, up, Lambda, False, correlated=False)[0] == pytest.approx(1 / 1.6)
