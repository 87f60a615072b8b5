"""Walk, low-variance walk and exact path integral are one model: per order and direction."""

import numpy as np
import pytest
from spheres import direction, evaluated, hemisphere, largest_z, sphere

from msbsdf_cli.methods.exact import Exact
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.walk import Walk
from msbsdf_cli.methods.walk_low_variance import WalkLowVariance
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.smith.walk import random_walk
from surfaces.materials import Conductor, Dielectric, Diffuse

RNG = np.random.default_rng
METAL = Conductor(((0.2, 3.9), (1.5, 2.0)))
WO = direction([0.2, 0.8, 1.3, 0.6, 1.2], [0.4, 0.5, 3.4, 3.3, 0.2])


@pytest.mark.parametrize("slopes", [Beckmann(1, 1), Ggx(1, 1), Beckmann(1, 0.1), Ggx(1, 0.1)])
@pytest.mark.parametrize("material", [METAL, Diffuse((0.9, 0.3))])
@pytest.mark.parametrize("theta", [0.1, 1.5])
def test_three_estimators_of_one_model(slopes, material, theta):
    wi, wo = direction(theta, 0.4), WO
    if slopes.alpha_x > slopes.alpha_y:
        wi, wo = direction(theta, 0.05), direction([0.2, 0.8, 1.2, 0.9], [0, 0.02, 3.1, 3.2])
    walk = evaluated(Walk(slopes, material, 2), wi, wo, 100000, RNG(1))
    for other in (Exact(slopes, material, 2), WalkLowVariance(slopes, material, 2)):
        got = evaluated(other, wi, wo, 50000, RNG(2))
        # 200 values for each slopes: beyond 4.5 standard errors one in 700 runs.
        assert largest_z(got, walk) < 4.5
        assert (got.stderr[:, 0] == 0).all()


@pytest.mark.parametrize("ior", [1.5, 1 / 1.5])
def test_low_variance_walk_through_a_dielectric(ior):
    wo = np.concatenate([WO, -WO], axis=1)
    wi, glass = direction(1.2, 0.4), Dielectric(ior)
    walk = evaluated(Walk(Ggx(1, 1), glass, 2), wi, wo, 200000, RNG(1))
    got = evaluated(WalkLowVariance(Ggx(1, 1), glass, 2), wi, wo, 15000, RNG(2))
    assert largest_z(got, walk) < 4.5


@pytest.mark.parametrize("material", [METAL, Diffuse((0.8,)), Dielectric(1.5)])
@pytest.mark.parametrize("slopes", [Beckmann(1, 1), Ggx(0.5, 0.5)])
def test_walk_sums_to_the_energies_of_the_random_walk(material, slopes):
    wi, samples, orders, batches = direction(1.0, 0.3), 100000, 2, 20
    # The lobe of transmission has a sharp edge, which the rule over directions sees coarsely.
    w, solid_angle = sphere(20 if material.transmits else 10)
    rule = 0.02 if material.transmits else 0.001
    energies = []
    for seed in range(batches):
        value = Walk(slopes, material, orders).evaluate(wi, w, 400, RNG(seed)).value[0]
        value *= solid_angle
        energies.append([value[:, w[2] > 0].sum(axis=1), value[:, w[2] < 0].sum(axis=1)])
    walked = np.zeros((2, orders + 1))
    for light in random_walk(slopes, material, wi, samples, RNG(1), 300):
        weight = np.ones(light.w.shape[1]) if light.weight is None else light.weight[0]
        row = min(light.order, orders + 1) - 1
        walked[:, row] += weight[light.w[2] > 0].sum(), weight[light.w[2] < 0].sum()
    walked /= samples
    mean = np.mean(energies, axis=0)
    stderr = np.hypot(
        np.std(energies, axis=0, ddof=1) / np.sqrt(batches), np.sqrt(walked / samples)
    )
    assert (np.abs(mean - walked) <= 4 * stderr + rule * walked).all()


@pytest.mark.parametrize("method", [Walk, WalkLowVariance, Exact])
def test_standard_errors_are_those_of_repeated_runs(method):
    model = method(Ggx(1, 1), Diffuse((1.0,)), 1)
    wi, wo = direction(0.5), direction([0.3, 1.2], [1, 3])
    runs = [model.evaluate(wi, wo, 400, RNG(seed)) for seed in range(60)]
    scatter = np.std([r.value[0, 1] for r in runs], axis=0, ddof=1)
    stated = np.sqrt(np.mean([r.stderr[0, 1] ** 2 for r in runs], axis=0))
    # 60 runs tell a scatter to 9 %. Without gathering a walk's later orders before squaring, the
    # stated error of this row would be 25 % too small.
    assert (np.abs(scatter / stated - 1) < 0.25).all()


@pytest.mark.parametrize("method", [Walk, Exact])
@pytest.mark.parametrize("material", [METAL, Diffuse((0.9, 0.3))])
def test_reciprocity(method, material):
    a, b = direction(0.3, 0.2), direction(1.2, 2.0)
    model = method(Ggx(1, 0.4), material, 2)
    there = evaluated(model, a, b[:, None], 60000, RNG(1))
    back = evaluated(model, b, a[:, None], 60000, RNG(2))
    ratio = b[2] / a[2]
    z = largest_z(there, back, ratio)
    assert z < 4


def test_reciprocity_of_transmission():
    # Light carries energy: towards the denser side it counts the squared index. The way back is
    # that of a dielectric of inverse index, upside down.
    a, b = direction(0.3, 0.2), direction(1.0, 2.0)
    there = evaluated(
        WalkLowVariance(Beckmann(1, 1), Dielectric(1.5), 2), a, -b[:, None], 40000, RNG(1)
    )
    back = evaluated(
        WalkLowVariance(Beckmann(1, 1), Dielectric(1 / 1.5), 2), b, -a[:, None], 40000, RNG(2)
    )
    ratio = 1.5**2 * b[2] / a[2]
    assert largest_z(there, back, ratio) < 4


def test_precision_of_the_result_follows_the_input():
    wi, wo = direction(0.5).astype(np.float32), direction([0.3, 1.2]).astype(np.float32)
    for method in (Walk, WalkLowVariance, Exact):
        single = method(Ggx(1, 1), Conductor(), 2).evaluate(wi, wo, 20000, RNG(1))
        double = method(Ggx(1, 1), Conductor(), 2).evaluate(
            wi.astype(float), wo.astype(float), 20000, RNG(1)
        )
        stderr = np.hypot(single.stderr, double.stderr)
        assert (np.abs(single.value - double.value) <= 4 * stderr + 1e-6).all()


def test_very_rough_surfaces_end():
    w, solid_angle = hemisphere(6)
    for method in (Walk, Exact):
        got = method(Ggx(20, 20), Conductor(), 2).evaluate(direction(0.5), w, 64, RNG(1))
        energy = (got.value[0] * solid_angle).sum()
        # 64 walks of dozens of bounces each, from 72 directions: an order of magnitude.
        assert 0.5 < energy < 2


def test_refusals_are_sentences():
    with pytest.raises(UnsupportedError, match="exact is for conductors and diffuse"):
        Exact(Beckmann(1, 1), Dielectric(), 2)
    with pytest.raises(UnsupportedError, match="index other than 1"):
        Walk(Beckmann(1, 1), Dielectric(1.0), 2)
