"""The walk that remembers the last facet, as a walk and as a method."""

import numpy as np
import pytest
from spheres import direction, hemisphere, sphere

import msbsdf_cli as ms
from msbsdf_cli.experiments.walk import WalkJob, run_walks
from msbsdf_cli.memory import hazard, march
from msbsdf_cli.memory.entry import Lambda
from msbsdf_cli.memory.facets import Conditional, facing, remembered, visible
from msbsdf_cli.memory.frame import curvature, directions, normals, slopes_along, turned
from msbsdf_cli.memory.march import NOWHERE
from msbsdf_cli.memory.next_facet import Memory
from msbsdf_cli.memory.normal import depth
from msbsdf_cli.memory.remembered import Remembered
from msbsdf_cli.memory.walk import random_walk
from msbsdf_cli.methods.protocol import UnsupportedError
from msbsdf_cli.methods.walk_memory import WalkMemory
from msbsdf_cli.smith.slopes import Beckmann, Ggx
from surfaces.materials import Conductor, Dielectric, Diffuse
from surfaces.spectrum import spectrum

RNG = np.random.default_rng
MATERIALS = [Conductor(), Diffuse(), Dielectric(1.5)]


def energies(lights, n):
    """Of orders 1 to 4 and all later ones."""
    found = np.zeros(5)
    for light in lights:
        weight = light.w.shape[1] if light.weight is None else light.weight[0].sum()
        found[min(light.order, 5) - 1] += weight / n
    return found


@pytest.mark.parametrize("material", MATERIALS, ids=lambda m: m.name)
@pytest.mark.parametrize("alpha", [(1.0, 1.0), (1.0, 0.1)])
def test_no_light_is_lost_or_made(material, alpha):
    n, wi = 20_000, direction(1.2, 0.4)
    lights = list(random_walk(Memory.of(), Beckmann(*alpha), material, wi, n, RNG(0), 10_000))
    assert energies(lights, n).sum() == pytest.approx(1, abs=1e-12)
    w = np.concatenate([light.w for light in lights], axis=1)
    np.testing.assert_allclose((w * w).sum(axis=0), 1, rtol=1e-9)
    assert material.transmits or (w[2] > 0).all()


def test_metals_and_grey_facets_absorb():
    gold, grey = Conductor.named("gold"), Diffuse(0.5)
    for material in (gold, grey):
        n, wi = 20_000, direction(0.5)
        args = Memory.of(), Beckmann(1, 1), material, wi, n
        found = energies(random_walk(*args, RNG(0), 1000), n)
        whole = energies(random_walk(*args[:2], material.lossless, wi, n, RNG(1), 1000), n)
        # Each facet keeps a half, exactly; gold keeps a fifth to a third at every angle.
        if material is grey:
            stderr = np.sqrt(whole * (1 - whole) / n)
            np.testing.assert_array_less(
                np.abs(found - whole * 0.5 ** np.arange(1, 6))[:4], 4 * stderr[:4] + 1e-3
            )
        else:
            assert 0.6 < found.sum() < 0.95


# Traced on 223 explicit surfaces of alpha 1: orders 1, 2, 3, 4, later, known to .0007 or better.
TRACED = {
    0.0: (0.4668, 0.4767, 0.0530, 0.0027, 0.0008),
    1.0: (0.7721, 0.1984, 0.0215, 0.0044, 0.0035),
    1.5: (0.9758, 0.0224, 0.0012, 0.0003, 0.0002),
}


@pytest.mark.parametrize("theta", TRACED)
def test_energies_are_nearer_to_surfaces_than_a_third_of_smiths(theta):
    n, wi, traced = 60_000, direction(theta), np.array(TRACED[theta])
    found = energies(random_walk(Memory.of(), Beckmann(1, 1), Conductor(), wi, n, RNG(2), 1000), n)
    smith = ms.walk(ms.Smith(Beckmann(1, 1), Conductor()), wi, samples=400_000)
    apart, smiths = (np.abs(e - traced).sum() / 2 for e in (found, smith.energy[:, 0]))
    noise = np.sqrt(found * (1 - found) / n).sum() / 2
    assert apart < smiths / 3 + noise


def test_walks_of_memory_0_are_smiths():
    """Bit for bit: nothing else is run."""
    model, wi = ms.Smith(Beckmann(1, 1), Conductor()), direction(1.0)
    a, b = (ms.walk(model, wi, samples=2000, **more).energy for more in ({}, {"memory": 0}))
    np.testing.assert_array_equal(a, b)
    assert not np.array_equal(a, ms.walk(model, wi, samples=2000, memory=1).energy)


@pytest.mark.parametrize(("c", "height"), [(0.3, 0.5), (1.0, -1.0)])
def test_a_surface_that_forgets_at_once_and_is_not_looked_back_on_is_smiths(c, height, monkeypatch):
    far = hazard.far
    monkeypatch.setattr(hazard, "far", lambda *a: far(*a)._replace(factor=np.ones_like(a[1])))
    n, cor = 40_000, Memory.of().correlation
    h, slope, x = (np.full(n, v, np.float32) for v in (height, c, 0))
    E = RNG(5).standard_exponential(n, dtype=np.float32)
    rays = march.Rays(
        np.stack([slope, h, x, x]), E, np.arange(n), x, *hazard.far(cor, h, slope)[:3]
    )
    met = 0
    while rays.size:
        rays, hits, _ = march._far_step(cor, rays, 0.25)
        met += hits.slot.size
    smith = np.exp(-Lambda(np.array(c)) * depth(np.array(height)))
    # The trapezoid is off by some thousandths.
    assert abs(1 - met / n - smith) < 4 * np.sqrt(smith * (1 - smith) / n) + 2e-3


@pytest.mark.parametrize("k", [-4.0, -0.5, 0.0, 2.5])
def test_facing_slopes_have_their_density(k):
    n = 60_000
    drawn = facing(np.full(n, k, np.float32), RNG(6))
    y = np.linspace(k, k + 14, 20_001)
    f = (y - k) * np.exp(-y * y / 2)
    assert (drawn >= k).all()
    for power in (1, 2):
        mean = (f * y**power).sum() / f.sum()
        assert abs((drawn**power).mean() - mean) < 4 * (drawn**power).std() / np.sqrt(n) + 1e-4


def test_normals_that_may_be_met_are_those_that_are_drawn():
    """The density of `Conditional` against draws: mean slopes by quadrature over normals."""
    slopes, memory, n = Beckmann(0.7, 0.4), Memory.of(), 60_000
    d = direction(2.0, 0.7)
    ray = directions(slopes, np.tile(d[:, None], n))
    facet = np.tile(np.array([[0.6], [-0.4], [ray.c[0] - 0.6], [0.5]], np.float32), n)
    place = np.full(n, memory.correlation.index(np.array([1.1]))[0])
    met = remembered(memory.correlation, place, ray, facet, np.full(n, 0.8, np.float32), RNG(7))
    along, across = met.draw(RNG(8))
    m, solid_angle = hemisphere(400)
    one = Conditional(slopes, ray.take(np.arange(1)).column(), met.take(np.arange(1)).column())
    weight = one.D(m[:, None])[0] * np.maximum(-(d @ m), 0) * solid_angle
    # The rule over normals is right to a few parts in a thousand.
    assert weight.sum() == pytest.approx(one.sigma[0, 0], rel=5e-3)
    s, q = slopes_along(slopes, ray.take(np.arange(1)), m)
    for drawn, node in ((along, s), (across, q), (along * across, s * q)):
        mean = (weight * node).sum() / weight.sum()
        assert abs(drawn.mean() - mean) < 4 * drawn.std() / np.sqrt(n) + 0.01
    back = slopes_along(slopes, ray, normals(slopes, ray, along, across))
    np.testing.assert_allclose(back, (along, across), atol=1e-5)


def test_curvatures_turn_as_a_surface_does():
    """Against the second derivative of a paraboloid."""
    rng = RNG(9)
    bends = rng.standard_normal((3, 5)).astype(np.float32)
    slopes = Beckmann(1, 1)
    ray, other = (
        directions(slopes, direction(1.0, phi)[:, None].repeat(5, 1)) for phi in (0.4, 2.0)
    )
    e, f = np.array([ray.x[0], ray.y[0]]), np.array([-ray.y[0], ray.x[0]])
    g = np.array([other.x[0], other.y[0]])
    expected = bends[0] * (g @ e) ** 2 + bends[1] * (g @ e) * (g @ f) + bends[2] * (g @ f) ** 2
    np.testing.assert_allclose(curvature(other, turned(ray, bends)), expected, atol=1e-5)


def test_facets_met_far_away_are_smiths():
    memory = Memory.of()
    ray = directions(Beckmann(1, 1), direction(2.0)[:, None].repeat(3, 1))
    facet, q = np.ones((4, 3), np.float32), np.ones(3, np.float32)
    a = remembered(memory.correlation, np.full(3, NOWHERE), ray, facet, q, RNG(1))
    b = visible(ray, 3, RNG(1))
    for mine, theirs in zip(vars(a).values(), vars(b).values(), strict=True):
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize("material", MATERIALS, ids=lambda m: m.name)
def test_values_add_up_to_the_energies_of_walks(material):
    """The first order, which has no noise for specular facets, and all orders together."""
    slopes, wi, n = Beckmann(1, 0.7), direction(1.1, 0.3), 40_000
    method = WalkMemory(slopes, material, 2)
    walked = energies(random_walk(method.memory, slopes, material, wi, n, RNG(3), 1000), n)
    w, solid_angle = sphere(16) if material.transmits else hemisphere(16)
    runs = np.array([method.evaluate(wi, w, 450, RNG(k)).value[0] @ solid_angle for k in range(4)])
    stderr = runs.std(axis=0, ddof=1) / 2
    noise = np.sqrt(walked * (1 - walked) / n)
    # The rule over directions, and what the table is off, come to less than 1 %.
    assert abs(runs.mean(axis=0)[0] - walked[0]) < 4 * np.hypot(stderr[0], noise[0]) + 0.01
    assert abs(runs.sum(axis=1).mean() - 1) < 4 * runs.sum(axis=1).std(ddof=1) / 2 + 0.01


def test_what_is_normalised_is_near_one_and_makes_the_reciprocity():
    method = WalkMemory(Beckmann(0.5, 0.5), Conductor(), 1)
    a, b = direction(0.3), direction(1.5, 2.5)
    norms = [method.entry_normalisation(w) for w in (a, b)]
    there = method.evaluate(a, b[:, None], 2, RNG(0)).value[0, 0, 0] / b[2]
    back = method.evaluate(b, a[:, None], 2, RNG(0)).value[0, 0, 0] / a[2]
    assert norms == pytest.approx([1, 1], abs=0.02)
    # But for its normalisation the first order is reciprocal, to rounding in single precision.
    assert there * norms[0] == pytest.approx(back * norms[1], rel=1e-3)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize(
    ("alpha", "theta"), [(1e-4, 1.5707), (0.5, np.nextafter(np.pi / 2, 0)), (0.5, 0.0), (20.0, 1.2)]
)
def test_far_ends_of_roughness_and_angle_are_no_special_cases(alpha, theta, dtype):
    method, wi = WalkMemory(Beckmann(alpha, alpha), Conductor(), 2), direction(theta, 0.3)
    wi = np.array([*wi[:2], abs(wi[2]) or 1e-30]).astype(dtype)
    w, weight = method.sample(wi, 500, RNG(0))
    assert np.isfinite(w).all()
    assert (weight == 1).all()
    found = method.evaluate(wi, hemisphere(6)[0].astype(dtype), 50, RNG(1))
    assert np.isfinite(found.value).all()
    assert (found.value >= 0).all()
    # Near the horizon, where the hazard is least exact, a tenth is made up for.
    assert method.entry_normalisation(wi) == pytest.approx(1, abs=0.15)


@pytest.mark.parametrize("number", [1, 2])
def test_light_from_the_horizon_goes_on_like_light_from_beside_it(number):
    """It meets the highest peaks, and comes down from them."""
    model, n, found = ms.Smith(Beckmann(5, 5), Diffuse()), 4000, []
    for theta in (1.57079632, np.nextafter(np.pi / 2, 0)):
        found.append(ms.walk(model, direction(theta), samples=n, memory=number).energy[0, 0])
    assert abs(found[0] - found[1]) < 4 * np.sqrt(2 * 0.24 / n)


def test_each_autocorrelation_gives_an_answer_of_its_own():
    wi, found = direction(1.4), {}
    for name in ("gaussian", "exponential"):
        model = ms.Smith(Beckmann(1, 1), Conductor())
        run = ms.walk(model, wi, samples=40_000, memory=1, autocorrelation=name)
        found[name] = run.energy[0, 0]
        assert run.settings["autocorrelation"] == name
        # The first order of values is a quadrature: 1 % is what the rule and its table leave.
        w, solid_angle = hemisphere(24)
        bsdf = ms.method("walk-memory", model, 1, autocorrelation=name)
        value = (bsdf.evaluate(wi, w, samples=4).value[0, 0] * solid_angle).sum()
        assert abs(value - found[name]) < 4 * np.sqrt(0.06 / 40_000) + 0.01 * value
    assert abs(found["gaussian"] - found["exponential"]) > 8 * np.sqrt(0.06 / 40_000)


def test_other_slopes_and_numbers_are_refused():
    with pytest.raises(UnsupportedError, match="beckmann"):
        ms.method("walk-memory", ms.Smith(Ggx(1, 1), Conductor()))
    with pytest.raises(ValueError, match="beckmann"):
        ms.walk(ms.Smith(Ggx(1, 1), Conductor()), direction(1.0), samples=2, memory=1)
    mirror = ms.Smith(Beckmann(1, 1), Conductor())
    with pytest.raises(ValueError, match="memory is 3"):
        ms.walk(mirror, direction(1.0), samples=2, memory=3)
    for name in "nonsense", 3, None:
        with pytest.raises(ValueError, match="not an autocorrelation"):
            ms.method("single", mirror, autocorrelation=name)
        with pytest.raises(ValueError, match="not an autocorrelation"):
            ms.walk(mirror, direction(1.0), samples=2, autocorrelation=name)


def test_jobs_are_repeated_exactly():
    model = ms.Smith(Beckmann(1, 1), Dielectric(1.5))
    job = WalkJob(model, direction(1.0), 4, 500, 3, 0, 0, 100, Remembered(spectrum("matern:1.5")))
    np.testing.assert_array_equal(run_walks(job)[1].sums, run_walks(job)[1].sums)
