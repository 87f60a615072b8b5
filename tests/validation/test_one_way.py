"""The random walk among facets that send all light one way."""

from msbsdf_cli.validation import one_way
from validation.fault_injection import assert_turns, each, long_free_paths, start_below_the_top

SIDEWAYS, GRAZING, *_ = one_way.hard()

PERTURBATIONS = [
    (
        long_free_paths,
        one_way.one_way,
        SIDEWAYS,
        1_000_000,
        "walk through a one-way facet",
    ),
    (
        start_below_the_top,
        one_way.one_way,
        GRAZING,
        10_000,
        "walk among one-way facets, orders",
    ),
]


@each(PERTURBATIONS)
def test_a_faulty_formula_turns_the_verdict(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
