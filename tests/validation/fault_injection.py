"""Faults put into formulas, used by several tests, and what must come of them."""

from functools import cache

import numpy as np
import pytest

from msbsdf_cli.methods import forced_collisions, walk, walks
from msbsdf_cli.methods.energy_compensated import EnergyCompensated
from msbsdf_cli.smith import walk as smith_walk
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from msbsdf_cli.statistics.multiple_testing import judge
from msbsdf_cli.validation import free_paths, height_walk, intersection
from msbsdf_cli.validation.configurations import Configuration
from surfaces.materials import Conductor, Dielectric, _material

ABOVE = Configuration(Beckmann(1.0, 1.0), (1.2, 0.0), (1.0, 2.0), heights="gaussian")
DOWN = Configuration(Ggx(1.0, 0.5), (2.2, 0.3), (0.7, 2.0), heights="uniform")
MIRROR = Configuration(Ggx(1.0, 1.0), (1.0, 0.3), (0.8, 2.5), material=Conductor())
GLASS = Configuration(Beckmann(1.5, 1.5), (1.2, 0.3), (2.6, 3.3), material=Dielectric())
ZENITH = np.array([[0.0], [0.0], [1.0]])


@cache
def failing(identity, configuration, samples, fault=None):
    """Names of the findings that fail; what several perturbations ask for is measured once."""
    with pytest.MonkeyPatch.context() as patch:
        if fault is not None:
            fault(patch)
        findings = list(identity(configuration, samples, np.random.default_rng(5)))
    return {row.finding.identity for row in judge(findings, 1e-3) if row.failed}


def each(perturbations):
    """A test for each of (fault, the identity that guards it, where, samples, what must fail)."""
    return pytest.mark.parametrize(
        ("fault", "identity", "configuration", "samples", "name"),
        perturbations,
        ids=[f"{fault.__name__}-{name}" for fault, _, _, _, name in perturbations],
    )


def assert_turns(fault, identity, configuration, samples, name):
    """The identity holds, and fails when the formula is faulty."""
    assert name not in failing(identity, configuration, samples)
    assert name in failing(identity, configuration, samples, fault)


def one_percent_more(function):
    return lambda *args, **kwargs: 1.01 * function(*args, **kwargs)


def bend_lambda(monkeypatch):
    """Lambda 1 % too large, above the surface and below it: 1 + Lambda grows by 1 % of Lambda."""
    for cls in (Beckmann, Ggx):
        right = cls.sigma

        def faulty(self, d, right=right):
            # sigma = Lambda cos upward, (1 + Lambda) cos downward.
            upward = right(self, np.where(d[2] > 0, d, -d))
            return right(self, d) + 0.01 * upward

        monkeypatch.setattr(cls, "sigma", faulty)


def lose_sign(monkeypatch):
    """Rays down take the step of rays up."""
    right = smith_walk.free_path

    def faulty(t, d, sigma, E):
        return right(t, np.abs(d), sigma, E)

    for module in (intersection, free_paths, height_walk, smith_walk):
        if hasattr(module, "free_path"):
            monkeypatch.setattr(module, "free_path", faulty)


def long_free_paths(monkeypatch):
    """All free paths 1 % too long."""
    right = smith_walk.free_path

    def faulty(t, d, sigma, E):
        return right(t, d, sigma, 1.01 * E)

    for module in (intersection, free_paths, smith_walk):
        monkeypatch.setattr(module, "free_path", faulty)


def start_below_the_top(monkeypatch):
    """Walks that arrive at t = 1e-3 instead of 0."""
    right = smith_walk._arrive

    def faulty(*args):
        lanes = right(*args)
        lanes.t = lanes.t + 1e-3
        return lanes

    monkeypatch.setattr(smith_walk, "_arrive", faulty)


def next_events_on_one_side(monkeypatch):
    """Next events towards the other side of a dielectric look from the same t."""
    for module in (walk, forced_collisions):
        monkeypatch.setattr(module, "escape", lambda t, inside, out: walks.escape(t, None, out))


def lambda_of_masking(monkeypatch):
    """Lambda 1 % too large where masking is measured, and nowhere else."""

    def faulty(c, t, w, rng):
        sigma = 1.01 * c.slopes.sigma(w)
        E = smith_walk.exponential(t.size, rng, float)
        return smith_walk.free_path(t, w, sigma, E)[0]

    monkeypatch.setattr(intersection, "leaves", faulty)


def flip_nothing(monkeypatch):
    for module in (smith_walk, intersection, walks):
        monkeypatch.setattr(module, "flip", lambda t: t)


def half_vector_below(monkeypatch):
    """D as if every normal were above the horizon."""
    for cls in (Beckmann, Ggx):
        right = cls.D
        monkeypatch.setattr(cls, "D", lambda self, m, right=right: right(self, m * np.sign(m[2])))

    def density(slopes, h, length):
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.nan_to_num(slopes.D(h / length))

    monkeypatch.setattr(_material, "density_of_half_vectors", density)


def normals_without_their_cosine(monkeypatch):
    """Normals of the surface instead of those seen."""
    for cls in (Beckmann, Ggx):
        right = cls.visible_normals
        monkeypatch.setattr(
            cls,
            "visible_normals",
            lambda self, wi, n, rng, right=right: right(self, ZENITH, n, rng),
        )


def lobe_off(monkeypatch):
    right = EnergyCompensated._lobe
    monkeypatch.setattr(
        EnergyCompensated, "_lobe", lambda self, wi, out: right(self, wi, out) * (1 + 0.2 * wi[2])
    )
