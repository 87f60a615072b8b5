"""Faults of multiple importance sampling that its identity sees."""

from msbsdf_cli.smith.slopes import Ggx
from msbsdf_cli.validation import shading
from msbsdf_cli.validation.configurations import Configuration
from msbsdf_cli.validation.shading import strategies
from surfaces.materials import Conductor, Dielectric
from validation.fault_injection import assert_turns, each

MIRROR = Configuration(Ggx(0.6, 0.6), (1.0, 0.3), material=Conductor(), method="walk")
GLASS = Configuration(Ggx(0.8, 0.8), (0.8, 0.3), material=Dielectric(1.5), method="walk")
N = 200_000


def share_of_the_other(monkeypatch):
    """Weights that do not sum to 1: the other's density twice."""
    right = shading._share
    monkeypatch.setattr(shading, "_share", lambda mine, other: right(mine, 2 * other))


PERTURBATIONS = [
    (share_of_the_other, strategies, GLASS, N, "samples of the bsdf, and of both weighed"),
    (share_of_the_other, strategies, MIRROR, N, "samples of the light, and of both weighed"),
]


@each(PERTURBATIONS)
def test_the_identity_turns(fault, identity, configuration, samples, name):
    assert_turns(fault, identity, configuration, samples, name)
