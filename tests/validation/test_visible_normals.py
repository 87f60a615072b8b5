"""Visible normals."""

from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.validation import visible_normals
from validation.fault_injection import (
    ABOVE,
    DOWN,
    assert_turns,
    bend_lambda,
    each,
    normals_without_their_cosine,
    one_percent_more,
)


def density_of_normals_off(monkeypatch):
    for cls in (Beckmann, Ggx):
        monkeypatch.setattr(cls, "D", one_percent_more(cls.D))


PERTURBATIONS = [
    (bend_lambda, visible_normals.normalisation, ABOVE, 1, "visible normals, normalisation"),
    (
        density_of_normals_off,
        visible_normals.normalisation,
        DOWN,
        1,
        "visible normals, normalisation",
    ),
    (
        normals_without_their_cosine,
        visible_normals.sampled_slopes,
        ABOVE,
        20_000,
        "visible normals, slopes",
    ),
    (
        normals_without_their_cosine,
        visible_normals.sampled_moments,
        ABOVE,
        20_000,
        "visible normals, E[x]",
    ),
]


@each(PERTURBATIONS)
def test_a_faulty_formula_turns_the_verdict(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
