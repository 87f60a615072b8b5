"""Distant masking and the segments of the position-free models."""

import numpy as np

from msbsdf_cli.methods import path_factors
from msbsdf_cli.smith import slopes
from msbsdf_cli.validation import position_free
from validation.fault_injection import (
    ABOVE,
    DOWN,
    assert_turns,
    bend_lambda,
    each,
    one_percent_more,
)


def chances_off(monkeypatch):
    for name in ("leaving_probability", "meeting_probability"):
        monkeypatch.setattr(position_free, name, one_percent_more(getattr(path_factors, name)))


def lambda_below(monkeypatch):
    """Lambda below the surface is that of above: the sign of [HHdD16] Eq. 22 is lost."""
    right = slopes.Lambda
    monkeypatch.setattr(position_free, "Lambda", lambda s, w: right(s, w * np.sign(w[2])))


PERTURBATIONS = [
    (bend_lambda, position_free.spherical_masking, ABOVE, 1, "distant masking, upward"),
    (bend_lambda, position_free.spherical_masking, DOWN, 1, "distant masking, downward"),
    (bend_lambda, position_free.spherical_masking, DOWN, 1, "distant masking as used, downward"),
    (
        bend_lambda,
        position_free.exceeds_one,
        ABOVE,
        1,
        "distant masking, angle where it exceeds 1",
    ),
    (lambda_below, position_free.spherical_masking, DOWN, 1, "distant masking, downward"),
    (chances_off, position_free.correlated, ABOVE, 1, "masking-shadowing from above, last bounce"),
    (chances_off, position_free.correlated, DOWN, 1, "masking-shadowing from below, middle bounce"),
    (
        chances_off,
        position_free.correlated,
        ABOVE,
        1,
        "masking-shadowing from above, last bounce, transmission",
    ),
    (chances_off, position_free.segment_terms, ABOVE, 1, "segment terms, uncorrelated, forward"),
    (chances_off, position_free.segment_terms, ABOVE, 1, "segment terms, correlated, inverse"),
]


@each(PERTURBATIONS)
def test_a_faulty_formula_turns_the_verdict(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
