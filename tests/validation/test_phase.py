"""Phase functions."""

from msbsdf_cli.smith import kernel
from msbsdf_cli.validation import phase
from surfaces.materials import conductor, dielectric
from validation.fault_injection import (
    GLASS,
    MIRROR,
    assert_turns,
    each,
    half_vector_below,
    normals_without_their_cosine,
)


def no_jacobian_of_reflection(monkeypatch):
    right = conductor.reflection_density

    def bent(*args):
        density, cos_i = right(*args)
        return 4 * density, cos_i

    monkeypatch.setattr(conductor, "reflection_density", bent)


def no_index_in_refraction(monkeypatch):
    right = dielectric.refraction_density

    def bent(slopes, eta, d, w):
        return right(slopes, eta, d, w) / eta**2

    monkeypatch.setattr(dielectric, "refraction_density", bent)


def unlike_phase(monkeypatch):
    """A facet's share of light depends on which way it goes, as Fresnel's must not."""
    right = kernel.scatter_density

    def bent(slopes, material, d, w, *args, **kwargs):
        return right(slopes, material, d, w, *args, **kwargs) * (1 + 1e-6 * d[2])

    monkeypatch.setattr(phase, "scatter_density", bent)


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
def test_a_bent_formula_turns_the_verdict(bend, identity, configuration, samples, name):
    assert_turns(bend, identity, configuration, samples, name)
