"""The method without noise."""

from dataclasses import replace
from functools import cache

import pytest

from msbsdf_cli.methods import solve
from msbsdf_cli.methods.solve import Solve
from msbsdf_cli.validation import solved
from validation.fault_injection import assert_turns, each, flip_nothing

SOLVED = solved.hard()[0]
SOLUTION = cache(solve.solution)


@pytest.fixture(autouse=True)
def haste(monkeypatch):
    """No fault is within a solution, so that each is made once; and none is of next events."""
    monkeypatch.setattr(solve, "solution", SOLUTION)
    monkeypatch.setattr(solved, "LEAST_WALKS", 1000)


def unbalanced(monkeypatch):
    """Energies that a solution forgets to normalise."""
    right = Solve.energy

    def faulty(self, wi):
        found = right(self, wi)
        return replace(found, reflected=1.001 * found.reflected)

    monkeypatch.setattr(Solve, "energy", faulty)


def one_way(monkeypatch):
    """Values that depend on where light comes from."""
    right = Solve.evaluate

    def faulty(self, wi, wo, *args):
        found = right(self, wi, wo, *args)
        return replace(found, value=found.value * (1 + 1e-3 * wi[2]))

    monkeypatch.setattr(Solve, "evaluate", faulty)


PERTURBATIONS = [
    (unbalanced, solved.solved, SOLVED, 1000, "energy, without noise"),
    (one_way, solved.solved, SOLVED, 1000, "reciprocity, without noise"),
    (one_way, solved.solved, SOLVED, 1000, "first order, without noise"),
    (
        flip_nothing,
        solved.solved,
        solved.hard()[2],
        20_000,
        "energies of orders, walk against solve",
    ),
]


@each(PERTURBATIONS)
def test_a_faulty_formula_turns_the_verdict(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
