"""What holds for every method: names, shapes, samples that follow the values."""

import numpy as np
import pytest
from spheres import direction, hemisphere, sphere

from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.registry import METHODS, holds
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from surfaces.facet import reflect
from surfaces.materials import Conductor, Dielectric, Diffuse, Material, Scattered

RNG = np.random.default_rng
MATERIALS = [Conductor(((0.2, 3.9), (1.5, 2.0))), Diffuse((0.9, 0.3, 0.5)), Dielectric(1.5)]
SAMPLED = [name for name, method in METHODS.items() if method.traits.samples]
REFUSED = {
    *(("exact", "dielectric"), ("energy-compensated", "diffuse")),
    *(("turquin", "diffuse"), ("turquin", "dielectric")),
}


class HalfMirror(Material):
    """A material that the program does not know, and that keeps half of each reflection."""

    absorbs = True

    def scatter(self, d, m, inside, rng):
        return Scattered(reflect(d, m), np.full((1, 1), 0.5))

    def reflection(self, normals, d, w, inside=False):
        density, _ = Conductor().reflection(normals, d, w)
        return density, np.full((1, *density.shape), 0.5)

    def reflectance(self, cos_i, inside=False):
        return np.full((1, *cos_i.shape), 0.5)


class TintedGlass(Dielectric):
    absorbs = True


class HalfSilvered(Dielectric):
    def reflectance(self, cos_i, inside=False):
        return np.full((1, *cos_i.shape), 0.5)


class Glossy(Diffuse):
    def lobe(self, cos_o):
        return 2 * super().lobe(cos_o) ** 2


@pytest.mark.parametrize("name", ["single", "walk", "solve"])
def test_an_unknown_mirror_keeps_half_at_each_facet(name):
    # Same walks, no roulette, and halves are exact: each order is that of a perfect mirror, halved
    # once for each facet.
    slopes, wi, wo = Ggx(0.8, 0.8), direction(0.8, 0.3), hemisphere(6)[0]
    half, full = (
        METHODS[name](slopes, material, 3).evaluate(wi, wo, 200, RNG(0)).value[0, :3]
        for material in (HalfMirror(), Conductor())
    )
    assert (full[0] > 0).any()
    np.testing.assert_allclose(half, full * [[0.5], [0.25], [0.125]], rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "material"),
    [*((name, TintedGlass()) for name in METHODS), ("solve", HalfSilvered()), ("solve", Glossy())],
    ids=lambda case: case if isinstance(case, str) else type(case).__name__,
)
def test_facets_that_a_method_does_not_follow_are_refused(name, material):
    with pytest.raises(UnsupportedError, match=f"method {name}"):
        METHODS[name](Ggx(0.8, 0.8), material, 2)


@pytest.mark.parametrize("name", SAMPLED)
@pytest.mark.parametrize("material", MATERIALS, ids=lambda m: m.name)
def test_samples_follow_the_values(name, material):
    if (name, material.name) in REFUSED:
        with pytest.raises(UnsupportedError, match=f"method {name}"):
            METHODS[name](Ggx(0.8, 0.8), material, 2)
        return
    method, wi = METHODS[name](Beckmann(1, 0.8), material, 2), direction(0.8, 0.3)
    assert method.name == name
    probe, solid_angle = sphere(16 if material.transmits else 10)
    # Of a method without noise, the second run shows that there is none.
    seeds = range(2 if method.deterministic else 8)
    runs = [method.evaluate(wi, probe, 300, RNG(seed)) for seed in seeds]
    shape = (material.channels, 3, probe.shape[1])
    assert runs[0].value.shape == runs[0].stderr.shape == shape
    assert all(np.isfinite(run.stderr).all() for run in runs)
    if not material.transmits:
        assert all((run.value[..., probe[2] < 0] == 0).all() for run in runs)
    w, weight = method.sample(wi, 40000, RNG(2))
    assert weight.shape == (material.channels, 40000)
    for g in (lambda w: np.ones(w.shape[1]), lambda w: w[2], lambda w: w[0]):
        sampled = weight * g(w)
        summed = np.array([(r.value.sum(axis=1) * g(probe) * solid_angle).sum(-1) for r in runs])
        noise = summed.std(axis=0, ddof=1) / np.sqrt(len(runs))
        stderr = np.hypot(sampled.std(axis=1) / 200, noise)
        # 1 % is the rule over directions.
        assert (np.abs(sampled.mean(axis=1) - summed.mean(axis=0)) < 4 * stderr + 0.01).all()


def test_solve_offers_no_samples():
    method = METHODS["solve"](Beckmann(1, 1), Conductor(), 1)
    for ask in (lambda: method.sample(direction(0.5), 3, RNG(0)), lambda: method.pdf(None, None)):
        with pytest.raises(UnsupportedError, match="solve"):
            ask()


@pytest.mark.parametrize("name", SAMPLED)
def test_densities_are_densities(name):
    w, solid_angle = hemisphere(48)
    for slopes in (Beckmann(0.6, 0.6), Ggx(1, 0.5)):
        if not holds(name, slopes, Conductor()):
            continue  # Of Gaussian surfaces only.
        method = METHODS[name](slopes, Conductor(), 2)
        total = (method.pdf(direction(0.9, 0.2), w) * solid_angle).sum()
        # What the first facet sends below the horizon is missing.
        assert 0.5 < total < 1 + 1e-3


def test_energy_compensation_returns_all_energy_and_is_reciprocal():
    w, solid_angle = hemisphere(48)
    for material in (Conductor(), Dielectric(1.5)):
        method = METHODS["energy-compensated"](Beckmann(1, 1), material, 3)
        wi, wo = direction(0.7), direction(1.2, 1.0)
        total = sum(
            (method.evaluate(wi, side * w, 0, RNG(0)).value[0].sum(axis=0) * solid_angle).sum()
            for side in (1, -1)
        )
        # The table's splines are right to 1e-3 here.
        assert abs(total - 1) < 1e-3
        there = method.evaluate(wi, wo[:, None], 0, RNG(0)).value[0, :, 0] / wo[2]
        back = method.evaluate(wo, wi[:, None], 0, RNG(0)).value[0, :, 0] / wi[2]
        np.testing.assert_allclose(there, back, rtol=1e-9)
        assert there[-1] > 0
        assert (there[1:-1] == 0).all()


def test_turquin_returns_all_energy_of_a_mirror_but_is_not_reciprocal():
    w, solid_angle = hemisphere(48)
    method = METHODS["turquin"](Ggx(1, 1), Conductor(), 1)
    total = (method.evaluate(direction(0.7), w, 0, RNG(0)).value[0].sum(axis=0) * solid_angle).sum()
    assert abs(total - 1) < 1e-3
    a, b = direction(0.2), direction(1.3)
    there = method.evaluate(a, b[:, None], 0, RNG(0)).value[0, 1, 0] / b[2]
    back = method.evaluate(b, a[:, None], 0, RNG(0)).value[0, 1, 0] / a[2]
    assert there / back > 1.5


def test_no_two_methods_look_alike():
    looks = [(method.traits.colour, method.traits.marker) for method in METHODS.values()]
    assert len(set(looks)) == len(METHODS)
    assert len({colour for colour, _ in looks}) == len(METHODS)
