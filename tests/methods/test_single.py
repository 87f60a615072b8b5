"""Single scattering: closed forms, the random walk's first order, sampling."""

import numpy as np
import pytest
from spheres import direction, hemisphere, sphere

from msbsdf_cli.methods.single import Single
from msbsdf_cli.smith.masking import masking_shadowing
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.smith.walk import random_walk
from surfaces.materials import Conductor, Dielectric, Diffuse

RNG = np.random.default_rng


def test_ggx_energy_at_normal_incidence():
    w, solid_angle = hemisphere(48)
    evaluation = Single(Ggx(1, 1), Conductor(), 2).evaluate(direction(0), w, 0, RNG(0))
    np.testing.assert_allclose(
        (evaluation.value[0] * solid_angle).sum(axis=1), [1 - np.log(2), 0, 0], atol=1e-6
    )
    assert (evaluation.stderr == 0).all()
    np.testing.assert_allclose(evaluation.unresolved, np.log(2), atol=1e-6)


@pytest.mark.parametrize("slopes", [Beckmann(1, 1), Ggx(0.6, 0.3)])
@pytest.mark.parametrize("theta", [0.2, 1.4])
@pytest.mark.parametrize(
    "material", [Conductor(((0.2, 3.9),)), Diffuse((0.7,)), Dielectric(1.5), Dielectric(1 / 1.5)]
)
def test_energy_is_the_first_order_of_the_random_walk(slopes, theta, material):
    wi, samples = direction(theta, 0.3), 40000
    w, solid_angle = sphere(24 if material.name == "diffuse" else 96)
    value = Single(slopes, material, 1).evaluate(wi, w, 0, RNG(0)).value[0, 0] * solid_angle
    energy = np.array([value[w[2] > 0].sum(), value[w[2] < 0].sum()])
    walked = np.zeros(2)
    for light in random_walk(slopes, material, wi, samples, RNG(1), 1):
        if light.resolved:
            weight = np.ones(light.w.shape[1]) if light.weight is None else light.weight[0]
            walked += weight[light.w[2] > 0].sum(), weight[light.w[2] < 0].sum()
    walked /= samples
    # 4 binomial standard errors, and 5e-4 for the rule over outgoing directions.
    assert (np.abs(energy - walked) < 4 * np.sqrt(walked * (1 - walked) / samples) + 5e-4).all()


@pytest.mark.parametrize("material", [Conductor(), Diffuse(), Dielectric()])
def test_samples_follow_the_density_and_the_value(material):
    method, wi = Single(Beckmann(0.8, 0.4), material, 1), direction(1.0, 0.3)
    w, weight = method.sample(wi, 40000, RNG(3))
    lit = weight[0] > 0
    # E[weight g(w)] is the integral of value g, by any density; a smooth g tells places apart.
    probe, solid_angle = sphere(20 if material.name == "diffuse" else 96)
    value = method.evaluate(wi, probe, 0, RNG(0)).value[0, 0]
    for g in (lambda w: 1 + 0 * w[2], lambda w: w[2], lambda w: w[0] ** 2, lambda w: w[1] * w[2]):
        got = weight[0] * g(w)
        expected = (value * g(probe) * solid_angle).sum()
        assert abs(got.mean() - expected) < 4 * got.std() / 200 + 5e-4
    lit = np.flatnonzero(lit)[:500]
    value = method.evaluate(wi, w[:, lit], 0, RNG(0)).value[0, 0]
    if material.name == "diffuse":
        # The facet that was sampled is one of many that send light there.
        return
    np.testing.assert_allclose(weight[0, lit], value / method.pdf(wi, w[:, lit]), rtol=1e-6)


def test_transmission_does_not_overflow():
    slopes = Beckmann(1, 1)
    wi, wo = direction(np.pi / 2 - 1e-7)[:, None], direction(np.pi / 2 - 1e-8)[:, None]
    assert np.isfinite(masking_shadowing(slopes, wi, wo, True)).all()
    assert np.isfinite(masking_shadowing(Ggx(100, 100), wi, wo, True)).all()
