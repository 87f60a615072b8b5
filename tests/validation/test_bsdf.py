"""Energy, samples and first order of the methods."""

from dataclasses import replace

from msbsdf_cli.methods import single, walk
from msbsdf_cli.methods.single import Single
from msbsdf_cli.smith import masking
from msbsdf_cli.validation import bsdf
from validation.fault_injection import (
    GLASS,
    MIRROR,
    assert_turns,
    bend_lambda,
    each,
    half_vector_below,
    lobe_off,
)


def masking_product(monkeypatch):
    right = masking.masking_shadowing

    def faulty(slopes, wi, wo, transmitted, correlated=True):
        return right(slopes, wi, wo, transmitted, False)

    monkeypatch.setattr(single, "masking_shadowing", faulty)


def escape_one_percent(monkeypatch):
    right = walk.escape
    monkeypatch.setattr(walk, "escape", lambda t, inside, out: right(1.03 * t, inside, out))


def samples_twice(monkeypatch):
    """Samples of single scattering that forget to be weighed by shadowing."""
    right = Single.sample

    def faulty(self, wi, n, rng):
        w, weight = right(self, wi, n, rng)
        return w, (weight > 0).astype(float)

    monkeypatch.setattr(Single, "sample", faulty)


PERTURBATIONS = [
    (bend_lambda, bsdf.first_order, replace(MIRROR, method="single"), 64, "first order"),
    (half_vector_below, bsdf.energy_and_samples, replace(MIRROR, method="walk"), 400_000, "energy"),
    (masking_product, bsdf.first_order, replace(MIRROR, method="single"), 64, "first order"),
    (masking_product, bsdf.first_order, replace(GLASS, method="single"), 64, "first order"),
    (
        escape_one_percent,
        bsdf.first_order,
        replace(MIRROR, method="walk", wi=(1.5, 0.3)),
        2_000_000,
        "first order",
    ),
    (
        samples_twice,
        bsdf.energy_and_samples,
        replace(MIRROR, method="single"),
        100_000,
        "samples against values, E[1]",
    ),
    (
        lobe_off,
        bsdf.energy_and_samples,
        replace(MIRROR, method="energy-compensated"),
        400_000,
        "energy",
    ),
]


@each(PERTURBATIONS)
def test_a_faulty_formula_turns_the_verdict(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
