"""Reciprocity, and the histogram of its differences."""

from dataclasses import replace

from msbsdf_cli.methods.position_free import PositionFree
from msbsdf_cli.validation import histogram, reciprocity
from validation.fault_injection import MIRROR, assert_turns, each, lobe_off


def correlated_for_uncorrelated(monkeypatch):
    right = PositionFree.__init__

    def faulty(self, *args, **kwargs):
        right(self, *args, **kwargs)
        self.correlated = True

    monkeypatch.setattr(PositionFree, "__init__", faulty)


def uncorrelated_for_correlated(monkeypatch):
    right = PositionFree.__init__

    def faulty(self, *args, **kwargs):
        right(self, *args, **kwargs)
        self.correlated = False

    monkeypatch.setattr(PositionFree, "__init__", faulty)


PERTURBATIONS = [
    (
        lobe_off,
        reciprocity.reciprocity,
        replace(MIRROR, method="energy-compensated"),
        64,
        "reciprocity",
    ),
    (
        correlated_for_uncorrelated,
        reciprocity.reciprocity,
        replace(MIRROR, method="position-free-uncorrelated", wi=(0.2, 0.0)),
        100_000,
        "reciprocity, order 2",
    ),
    (
        uncorrelated_for_correlated,
        reciprocity.failing,
        reciprocity.not_reciprocal()[0],
        10_000,
        "reciprocity, order 2",
    ),
    (
        correlated_for_uncorrelated,
        histogram.differences,
        replace(MIRROR, method="position-free-uncorrelated"),
        10_000,
        "reciprocity, mean of differences",
    ),
    (
        uncorrelated_for_correlated,
        histogram.differences,
        replace(MIRROR, method="position-free-correlated"),
        10_000,
        "reciprocity, mean of differences",
    ),
]


@each(PERTURBATIONS)
def test_a_faulty_formula_turns_the_verdict(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
