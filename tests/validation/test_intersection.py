"""Masking and shadowing as chances to meet the surface."""

import numpy as np

from msbsdf_cli.methods import walks
from msbsdf_cli.smith import walk as smith_walk
from msbsdf_cli.validation import intersection
from validation.fault_injection import (
    ABOVE,
    assert_turns,
    bend_lambda,
    each,
    flip_nothing,
    lose_sign,
)


def flip_sides_of_t(monkeypatch):
    """C1 -> 1 / (1 + C1), a slip of the sign."""
    for module in (smith_walk, intersection, walks):
        monkeypatch.setattr(module, "flip", lambda t: np.log1p(np.exp(-t)))


PERTURBATIONS = [
    (bend_lambda, intersection.masking, ABOVE, 4_000_000, "masking"),
    (bend_lambda, intersection.masking_shadowing, ABOVE, 4_000_000, "masking-shadowing"),
    (
        bend_lambda,
        intersection.masking_shadowing,
        ABOVE,
        4_000_000,
        "masking-shadowing, transmission",
    ),
    (lose_sign, intersection.shadowing_given_masking, ABOVE, 10_000, "shadowing given masking"),
    (
        flip_nothing,
        intersection.masking_shadowing,
        ABOVE,
        100_000,
        "masking-shadowing, transmission",
    ),
    (
        flip_nothing,
        intersection.shadowing_given_masking,
        ABOVE,
        100_000,
        "shadowing given masking, transmission",
    ),
    (
        flip_sides_of_t,
        intersection.masking_shadowing,
        ABOVE,
        100_000,
        "masking-shadowing, transmission",
    ),
]


@each(PERTURBATIONS)
def test_a_faulty_formula_turns_the_verdict(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
