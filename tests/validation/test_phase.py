"""Phase functions."""

from msbsdf_cli.validation import phase
from surfaces.materials import Conductor, Dielectric
from validation.fault_injection import (
    GLASS,
    MIRROR,
    assert_turns,
    each,
    half_vector_below,
    normals_without_their_cosine,
)


def no_jacobian_of_reflection(monkeypatch):
    right = Conductor.reflection

    def faulty(*args):
        density, colour = right(*args)
        return 4 * density, colour

    monkeypatch.setattr(Conductor, "reflection", faulty)


def no_index_in_refraction(monkeypatch):
    right = Dielectric.refraction

    def faulty(self, normals, d, w, inside=False):
        return right(self, normals, d, w, inside) / self.relative_ior(inside) ** 2

    monkeypatch.setattr(Dielectric, "refraction", faulty)


def unlike_phase(monkeypatch):
    """What a facet sends depends on which way it goes, as Fresnel's law must not."""
    right = Conductor.density

    def faulty(self, normals, d, w, *args, **kwargs):
        return right(self, normals, d, w, *args, **kwargs) * (1 + 1e-6 * d[2])

    monkeypatch.setattr(Conductor, "density", faulty)


PERTURBATIONS = [
    (half_vector_below, phase.phase_function, MIRROR, 100_000, "phase function, normalisation"),
    (
        no_jacobian_of_reflection,
        phase.phase_function,
        MIRROR,
        20_000,
        "phase function, normalisation",
    ),
    (no_index_in_refraction, phase.phase_function, GLASS, 20_000, "phase function, normalisation"),
    (
        no_index_in_refraction,
        phase.reciprocity,
        GLASS,
        1,
        "phase function, reciprocity through facets",
    ),
    (unlike_phase, phase.reciprocity, MIRROR, 1, "phase function, reciprocity"),
    (
        normals_without_their_cosine,
        phase.phase_function,
        MIRROR,
        100_000,
        "phase function, E[x]",
    ),
]


@each(PERTURBATIONS)
def test_a_faulty_formula_turns_the_verdict(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
