"""Free paths, and heights seen along them."""

from msbsdf_cli.methods import forced_collisions
from msbsdf_cli.smith import walk as smith_walk
from msbsdf_cli.smith.heights import Gaussian
from msbsdf_cli.smith.slopes import Beckmann
from msbsdf_cli.validation import free_paths, intersection
from msbsdf_cli.validation.configurations import Configuration
from validation.fault_injection import (
    ABOVE,
    DOWN,
    assert_turns,
    bend_lambda,
    each,
    long_free_paths,
    lose_sign,
    one_percent_more,
)

GRAZING = Configuration(Beckmann(1.0, 1.0), (1.5, 0.0), heights="gaussian")


def heights_off(monkeypatch):
    right = Gaussian.t
    monkeypatch.setattr(Gaussian, "t", lambda self, h: 1.01 * right(self, h))


def exponentials_off(monkeypatch):
    right = smith_walk.exponential
    for module in (smith_walk, intersection, free_paths):
        monkeypatch.setattr(module, "exponential", one_percent_more(right))


def forced_too_far(monkeypatch):
    """Forced free paths, 1 % too long."""
    right = forced_collisions.forced_free_path

    def faulty(t, d, sigma, rng):
        facet, chance = right(t, d, sigma, rng)
        return t + 1.01 * (facet - t), chance

    monkeypatch.setattr(free_paths, "forced_free_path", faulty)


def always_down_to_the_bottom(monkeypatch):
    def faulty(t, d, sigma, E):
        return E * d[2] > t * sigma, t * 0

    monkeypatch.setattr(free_paths, "free_path", faulty)


PERTURBATIONS = [
    (bend_lambda, free_paths.extinction, ABOVE, 1, "projected area"),
    (bend_lambda, free_paths.visible_heights, GRAZING, 4_000_000, "visible heights"),
    (lose_sign, free_paths.table_3, DOWN, 1000, "Table 3, down"),
    (lose_sign, free_paths.table_3, DOWN, 1000, "Table 3, straight down"),
    (lose_sign, free_paths.distribution, DOWN, 10_000, "free path, distribution"),
    (lose_sign, free_paths.distribution, DOWN, 10_000, "free path, Dirac part"),
    (lose_sign, free_paths.visible_heights, ABOVE, 10_000, "visible heights"),
    (always_down_to_the_bottom, free_paths.table_3, ABOVE, 1000, "Table 3, level"),
    (always_down_to_the_bottom, free_paths.table_3, ABOVE, 1000, "Table 3, straight down"),
    (long_free_paths, free_paths.optical_depth, DOWN, 500_000, "free path, optical depth"),
    (long_free_paths, free_paths.optical_depth, GRAZING, 500_000, "free path, optical depth"),
    (forced_too_far, free_paths.optical_depth, DOWN, 500_000, "free path, optical depth, forced"),
    (heights_off, free_paths.extinction, ABOVE, 1, "extinction coefficient"),
    (heights_off, free_paths.distribution, ABOVE, 1000, "free-path density and Dirac part"),
    (exponentials_off, free_paths.visible_heights, ABOVE, 4_000_000, "visible heights"),
]


@each(PERTURBATIONS)
def test_a_faulty_formula_turns_the_verdict(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
