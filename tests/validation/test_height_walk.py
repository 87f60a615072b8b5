"""The walk over heights."""

from dataclasses import replace

from msbsdf_cli.validation import height_walk
from validation.fault_injection import GLASS, assert_turns, each, flip_nothing

PERTURBATIONS = [
    (
        flip_nothing,
        height_walk.height_independence,
        replace(GLASS, heights="gaussian"),
        100_000,
        "independence of the height distribution",
    ),
]


@each(PERTURBATIONS)
def test_a_faulty_formula_turns_the_verdict(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
